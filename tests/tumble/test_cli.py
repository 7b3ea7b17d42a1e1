"""The command as a user meets it: results, exit codes, one line for every mistake, nothing half-written."""

import csv
import io
import os
import resource
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from patience import PATIENCE_S, until, without_progress

TRAJECTORY = (
    "t_s,x_m,y_m,z_m,qw,qx,qy,qz,vx_m_s,vy_m_s,vz_m_s,wx_rad_s,wy_rad_s,wz_rad_s,"
    + ",".join(f"v{k}{axis}_m" for k in range(8) for axis in "xyz")
)  # fmt: skip
VERTEX_ERRORS = (
    "scene,engine,method,dt_s,tolerance,t_s,vertex,true_x_m,true_y_m,true_z_m,x_m,y_m,z_m,"
    "error_x_m,error_y_m,error_z_m,error_m"
)
RUNS = (
    "scene,engine,method,dt_s,tolerance,steps,status,why,max_error_m,rms_error_m,final_error_m,resolution_m,"
    "energy_drift,momentum_drift,angular_momentum_drift,wall_s,wall_ns_per_step,wall_per_sim_s,"
    "dt_taken_s"
)


def rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def test_run_gives_a_trajectory(tumble):
    done = tumble("run", "table-4-1")
    assert done.returncode == 0
    assert done.stderr == ""
    assert done.stdout.splitlines()[0] == TRAJECTORY
    times = [float(row["t_s"]) for row in rows(done.stdout)]
    assert times == [0.0, 0.06, 0.28, 0.36, 0.42, 0.5]


def test_two_runs_give_identical_bytes(tumble):
    assert tumble("run", "brick-tumble").stdout == tumble("run", "brick-tumble").stdout


def test_dt_is_the_step_used(tumble):
    coarse, fine = (tumble("run", "brick-tumble", "-e", "mujoco:euler", "--dt", dt).stdout for dt in ("0.01", "0.001"))
    assert coarse != fine


def test_compare_writes_every_vertex(tumble, tmp_path):
    done = tumble("compare", "table-4-1", "-e", "tumble:rk4", "-e", "handcalc:as-printed", "-o", "out")
    assert done.returncode == 0
    vertex_errors = (tmp_path / "out/vertex-errors.csv").read_text()
    assert vertex_errors.splitlines()[0] == VERTEX_ERRORS
    assert len(rows(vertex_errors)) == 2 * 5 * 8
    runs = (tmp_path / "out/runs.csv").read_text()
    assert runs.splitlines()[0] == RUNS
    for run in rows(runs):
        own = [float(row["error_m"]) for row in rows(vertex_errors) if row["method"] == run["method"]]
        assert float(run["max_error_m"]) == max(own)
        assert float(run["rms_error_m"]) == pytest.approx((sum(e * e for e in own) / len(own)) ** 0.5)
    # Table 4.1's vertex at its first row, printed there as (1.84, -0.75, 2.94) by hand.
    assert "(1.83, -0.75, 2.9" in done.stdout
    assert "vertex 5" in done.stdout
    assert "2.775" in done.stdout, "its largest distance from the application column"


def test_compare_fits_80_columns(tumble):
    done = tumble("compare", "table-4-1", "-e", "mujoco:rk4", env={**os.environ, "COLUMNS": "80"})
    tables = [line for line in done.stdout.splitlines() if line.startswith(" 0.")]
    assert tables
    assert max(map(len, tables)) <= 80


@pytest.mark.parametrize("command", ["scenes", "engines"])
def test_lists(tumble, command):
    done = tumble(command)
    assert done.returncode == 0
    assert done.stderr == ""
    expected = {"scenes": ["table-4-1", "mesh-die", "gyroscopic"], "engines": ["tumble", "pybullet", "mujoco", "rk4"]}
    assert all(word in done.stdout for word in expected[command])


REFUSED = {
    ("run", "brik-tumble"): "unknown scene 'brik-tumble': did you mean 'brick-tumble'?",
    ("run", "no/such.toml"): "no/such.toml",
    ("run", "table-4-1", "-e", "mujocco"): "unknown engine 'mujocco': did you mean 'mujoco'?",
    ("run", "table-4-1", "-e", "tumble:rk44"): "unknown method of tumble 'rk44': did you mean 'rk4'?",
    ("run", "table-4-1", "-e", "./none.py"): "./none.py: no such engine file",
    ("run", "table-4-1", "--dt", "0"): "argument --dt: '0' is not a positive number of seconds",
    ("run", "table-4-1", "--dt", "nan"): "argument --dt: 'nan' is not a positive number of seconds",
    ("run", "table-4-1", "-e", "tumble", "-e", "mujoco"): "run takes one engine",
    ("run", "brick-tumble", "-e", "handcalc"): "handcalc:as-printed on brick-tumble: skipped:",
    ("compare", "table-4-1", "--vertex", "8"): "--vertex = 8: table-4-1 has vertices 0 to 7",
    ("run", "table-4-1", "--dt", "1e-12"): "--dt = 1e-12: must be at least 5e-10 s for table-4-1",
    ("report", "table-4-1", "--dt", "1e-12"): "--dt = 1e-12: must be at least 5e-10 s for table-4-1",
    ("compare",): "the following arguments are required: SCENE",
    ("no-such-command",): "'no-such-command': there are scenes, engines",
}


@pytest.mark.parametrize("words", REFUSED, ids=" ".join)
def test_mistakes_are_refused_in_one_line(tumble, words):
    done = tumble(*words)
    assert done.returncode == 2, done.stderr
    assert REFUSED[words] in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert done.stdout == ""


def test_an_output_that_cannot_be_written_is_refused(tumble, tmp_path):
    (tmp_path / "file").write_text("mine")
    for words in (("run", "table-4-1", "-o", "file/x.csv"), ("compare", "table-4-1", "-o", "file")):
        done = tumble(*words)
        assert done.returncode == 2
        assert len(done.stderr.splitlines()) == 1
        assert "file" in done.stderr
    assert (tmp_path / "file").read_text() == "mine"


def test_a_full_disk_leaves_no_half_written_file(tumble, tmp_path):
    # A file may grow to 1000 bytes only: what a full disk does to a write, without filling one.
    done = tumble(
        "run", "brick-tumble", "-o", "out.csv",
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)),
    )  # fmt: skip
    assert done.returncode == 2
    assert "File too large" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert os.listdir(tmp_path) == []


def test_standard_output_on_a_full_device_is_one_line(tumble):
    with open("/dev/full", "w") as full:
        done = tumble("run", "table-4-1", capture_output=False, stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 2
    assert done.stderr == "tumble: No space left on device\n"


def test_a_reader_that_leaves_early_is_no_error(tmp_path):
    command = f"{sys.executable} -P -m tumble run brick-tumble | head -1; echo ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", command], cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE_S)
    assert done.stdout.splitlines() == [TRAJECTORY, "0"]
    assert done.stderr == ""


@pytest.mark.parametrize("command", ["compare two-hits -e mujoco:euler", "ablate spin-fast -e tumble:rk4", "grade"])
def test_a_reader_that_leaves_early_has_the_tables(tmp_path, command):
    if command == "grade":
        flown = [sys.executable, "-P", "-m", "tumble", "run", "two-hits", "-e", "mujoco:euler", "-o", "their.csv"]
        subprocess.run(flown, cwd=tmp_path, check=True, capture_output=True, timeout=PATIENCE_S)
        command = "grade their.csv --scene two-hits"
    words = [sys.executable, "-P", "-m", "tumble", *command.split(), "-o", "kept"]
    with subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
        process.stdout.close()
        assert process.wait(PATIENCE_S) == 0
    assert len(list((tmp_path / "kept").glob("*.csv"))) > 2


def test_ctrl_c_ends_everything_and_writes_nothing(tmp_path):
    (tmp_path / "slow.py").write_text(
        "import os, time\nMETHODS = ('m',)\nFEATURES = set()\nABOUT = {}\ndef build(scene, method): return {}\n"
        "def write(world, states): world['s'] = states\n"
        f"def advance(world, n, dt): open({str(tmp_path / 'pid')!r}, 'w').write(str(os.getpid())); time.sleep(100)\n"
        "def read(world): return world['s']\n"
    )
    words = [
        sys.executable,
        "-P",
        "-m",
        "tumble",
        "compare",
        "table-4-1",
        "-e",
        "./slow.py",
        "-e",
        "tumble",
        "-o",
        "out",
    ]
    with subprocess.Popen(
        words, cwd=tmp_path, stderr=subprocess.PIPE, text=True, start_new_session=True, preexec_fn=heed_ctrl_c
    ) as process:
        until(lambda: (tmp_path / "pid").exists() and (tmp_path / "pid").read_text())
        os.killpg(process.pid, signal.SIGINT)
        _, stderr = process.communicate(timeout=PATIENCE_S)
    # Python itself ends by the signal where the interrupt fell into an import in C; a shell shows 130 for either.
    assert process.returncode in (130, -signal.SIGINT)
    assert without_progress(stderr) == "tumble: interrupted; nothing was written\n"
    assert os.listdir(tmp_path / "out") == []
    worker = int((tmp_path / "pid").read_text())
    until(lambda: not os.path.exists(f"/proc/{worker}"))


def test_ctrl_c_ends_a_report_while_a_ladder_hangs_in_another_thread(tmp_path):
    (tmp_path / "slow.py").write_text(
        "import pathlib, time\n"
        "METHODS = ('m',)\nFEATURES = {'gravity'}\n"
        "ABOUT = {'version': '', 'precision': 'double', 'switched_off': []}\n"
        "def build(scene, method): return {}\n"
        "def write(world, states): world['s'] = states\n"
        "def read(world): return world['s']\n"
        "def advance(world, n, dt):\n"
        "    if n > 5000:\n"  # no flight has so many steps but those of a ladder
        f"        pathlib.Path({str(tmp_path / 'hangs')!r}).touch()\n"
        "        time.sleep(1000)\n"
    )
    words = [sys.executable, "-P", "-m", "tumble", "report", "die-straight", "-e", "./slow.py", "--time-limit", "900"]
    with subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE, text=True, preexec_fn=heed_ctrl_c) as process:
        try:
            until((tmp_path / "hangs").exists)
            time.sleep(1)  # the command itself waits for the engine's other flights, or has its tables
            process.send_signal(signal.SIGINT)
            _, stderr = process.communicate(timeout=PATIENCE_S)
        finally:
            process.kill()
    assert without_progress(stderr) == "tumble: interrupted; nothing was written\n"


def heed_ctrl_c() -> None:
    """Set SIGINT to what it does in a terminal: whoever started the tests may have told them to ignore it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def test_help_imports_nothing_heavy(tumble, tmp_path):
    code = "import sys; from tumble.__main__ import main\ntry: main(['--help'])\nexcept SystemExit: pass\n"
    code += "print(sorted({'numpy', 'numba', 'rich', 'mpmath', 'mujoco', 'msgspec'} & set(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-P", "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE_S
    )
    assert done.stdout.splitlines()[-1] == "[]"


def test_a_grade_for_a_script_loads_no_tables_and_nothing_of_sensors():
    code = "import sys, tumble.commands.grade\n"
    code += "print([each for each in sys.modules if each == 'rich' or 'sensor_' in each or '.tables' in each])"
    done = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, timeout=PATIENCE_S)
    assert done.stdout == "['tumble.compare.grade.read.sensor_rows']\n", done.stderr


@pytest.mark.parametrize(
    ("closed", "code", "said"), [(">&-", 2, "Bad file descriptor"), ("<&-", 0, ""), ("2>&-", 0, "")]
)
@pytest.mark.parametrize("words", ["scenes", "run table-4-1"])
def test_a_stream_that_is_closed_is_no_bug(tmp_path, words, closed, code, said):
    command = f"{sys.executable} -P -m tumble {words} {closed}"
    done = subprocess.run(["bash", "-c", command], cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE_S)
    assert done.returncode == code, done.stderr
    assert said in done.stderr
    assert bool(done.stdout) == (code == 0)


def test_nothing_is_left_in_the_working_folder(tumble, tmp_path):
    assert tumble("compare", "brick-tumble", "--dt", "0.2").returncode == 0
    assert os.listdir(tmp_path) == []


def test_an_engine_that_is_not_installed_is_a_row_with_its_reason(tumble, tmp_path):
    (tmp_path / "shadow").mkdir()
    (tmp_path / "shadow/pybullet.py").write_text("raise ModuleNotFoundError('no wheel', name='pybullet')\n")
    without = {"env": {**os.environ, "PYTHONPATH": str(tmp_path / "shadow")}}
    listed = tumble("engines", **without)
    assert listed.returncode == 0
    assert "missing: no module named pybullet" in listed.stdout
    assert tumble("compare", "table-4-1", "-o", "out", **without).returncode == 0
    told = {row["engine"]: (row["status"], row["why"]) for row in rows((tmp_path / "out/runs.csv").read_text())}
    assert told["pybullet"][0] == "missing"
    assert told["pybullet"][1].startswith("no module named pybullet")
    asked = tumble("run", "table-4-1", "-e", "pybullet:rigidbody", **without)
    assert asked.returncode == 2
    assert "pybullet:rigidbody on table-4-1: missing: no module named pybullet" in asked.stderr


def test_two_scenes_of_one_name_are_refused(tumble, tmp_path):
    scene = 'title = "t"\nduration = 1.0\nsamples = 1\nstep = 0.1\n'
    (tmp_path / "table-4-1.toml").write_text(scene + '[body]\nshape = "box"\nsize = [1.0, 1.0, 1.0]\nmass = 1.0\n')
    done = tumble("report", "table-4-1", "./table-4-1.toml")
    assert done.returncode == 2
    assert done.stderr == "tumble: two scenes are named 'table-4-1': rename one of the files\n"
    assert os.listdir(tmp_path) == ["table-4-1.toml"]


def test_what_an_engine_has_not_is_skipped(tumble, tmp_path):
    (tmp_path / "tied.toml").write_text(
        'title = "tied"\nduration = 1.0\nsamples = 4\nstep = 0.01\n[body]\nshape = "box"\nsize = [1.0, 0.5, 0.2]\n'
        "mass = 1.0\n[[tether]]\nvertex = 7\nanchor = [0.0, 2.0, 0.0]\nstiffness = 80.0\n"
    )
    assert tumble("compare", "./tied.toml", "-o", "out").returncode == 0
    statuses = {
        f"{row['engine']}:{row['method']}": ": ".join(filter(None, (row["status"], row["why"])))
        for row in rows((tmp_path / "out/runs.csv").read_text())
    }
    assert not any(name.startswith("handcalc") for name in statuses), "it is of another scene, and nobody asked for it"
    assert statuses["mujoco:rk4"] == statuses["mujoco:rk4+held"] == "ok"
    held_only = "multibody has none of these laws itself; multibody+held is given their force once a step"
    assert statuses["pybullet:multibody"] == f"skipped: {held_only}"
    assert statuses["pybullet:rigidbody+held"] == "ok"
    asked = tumble("run", "./tied.toml", "-e", "pybullet")
    assert asked.returncode == 2
    assert asked.stderr == f"tumble: pybullet:multibody on tied: skipped: {held_only}\n"


def test_run_without_an_engine_takes_a_method_that_has_a_plane(tumble, tmp_path):
    """Where there is a floor too it is skipped at once, by name: nothing is compiled here."""
    floor = "[floor]\nheight = -9.0\nstiffness = 1e4\n"
    (tmp_path / "both.toml").write_text(tumble("scenes", "box-slide-0").stdout + floor)
    done = tumble("run", "both.toml", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (2, "tumble: tumble:events on both: skipped: events has no floor\n")


@pytest.mark.parametrize("method", ["euler", "rk4", "implicit", "implicitfast", "discrete"])
def test_run_equals_a_bare_mujoco_loop_bit_for_bit(tumble, method):
    import mujoco

    from tumble.scenarios.read import read_scene

    scene = read_scene("brick-tumble")
    mass, (x, y, z), (gx, gy, gz) = scene.body.mass, scene.body.moments.tolist(), scene.gravity.tolist()
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option integrator="{ {"euler": "Euler", "rk4": "RK4"}.get(method, method) }"'
        f' timestep="{scene.step!r}" gravity="{gx!r} {gy!r} {gz!r}"/><worldbody><body><freejoint/>'
        f'<inertial pos="0 0 0" mass="{mass!r}" diaginertia="{x!r} {y!r} {z!r}"/></body></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    data.qpos[:] = scene.start[0, 0:7]
    data.qvel[:] = scene.start[0, 7:13]  # at the identity attitude body axes are world axes
    for row in rows(tumble("run", "brick-tumble", "-e", f"mujoco:{method}").stdout):
        while data.time < float(row["t_s"]) - scene.step / 2:
            mujoco.mj_step(model, data)
        pose = [float(row[name]) for name in ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")]
        velocity = [float(row[name]) for name in ("vx_m_s", "vy_m_s", "vz_m_s")]
        assert pose == data.qpos.tolist()
        assert velocity == data.qvel[:3].tolist()


@pytest.mark.parametrize("method", ["multibody", "rigidbody"])
def test_run_equals_a_bare_pybullet_loop_bit_for_bit(tumble, method):
    import pybullet

    from tumble.scenarios.read import read_scene

    scene = read_scene("brick-tumble")
    client = pybullet.connect(pybullet.DIRECT)
    try:
        pybullet.setGravity(*scene.gravity, physicsClientId=client)
        pybullet.setTimeStep(scene.step, physicsClientId=client)
        body = pybullet.createMultiBody(1.0, useMaximalCoordinates=method == "rigidbody", physicsClientId=client)
        pybullet.changeDynamics(
            body, -1, mass=scene.body.mass, localInertiaDiagonal=scene.body.moments.tolist(),
            linearDamping=0, angularDamping=0, maxJointVelocity=1e30, physicsClientId=client,
        )  # fmt: skip
        (x, (w, *xyz), v, spin) = (scene.start[0, part].tolist() for part in np.split(np.arange(13), [3, 7, 10]))
        pybullet.resetBasePositionAndOrientation(body, x, [*xyz, w], physicsClientId=client)
        pybullet.resetBaseVelocity(body, v, spin, physicsClientId=client)
        steps = 0
        for row in rows(tumble("run", "brick-tumble", "-e", f"pybullet:{method}").stdout):
            while steps < round(float(row["t_s"]) / scene.step):
                pybullet.stepSimulation(physicsClientId=client)
                steps += 1
            x, (*xyz, w) = pybullet.getBasePositionAndOrientation(body, physicsClientId=client)
            v, spin = pybullet.getBaseVelocity(body, physicsClientId=client)
            assert [float(value) for value in list(row.values())[1:14]] == [*x, w, *xyz, *v, *spin]
    finally:
        pybullet.disconnect(client)


def test_auto_says_what_it_took(tumble):
    done = tumble("run", "two-hits", "-e", "tumble:auto")
    assert done.returncode == 0
    assert done.stderr == (
        "tumble: tumble:auto took exact: a free flight has a closed form, and nothing is cheaper at any error\n"
    )
    assert done.stdout == tumble("run", "two-hits", "-e", "tumble:exact").stdout
    assert "tumble:auto took exact" in tumble("compare", "two-hits", "-e", "tumble:auto").stdout


def test_compare_begins_with_the_answer_and_holds_back_the_tables_of_other_methods(tumble):
    words = ("compare", "two-hits", "-e", "tumble:rk4", "-e", "mujoco")
    short, long = tumble(*words), tumble(*words, "--all")
    first = short.stdout.splitlines()
    assert first[0].startswith("two-hits: ")
    assert " is most accurate, " in first[0]
    assert "mujoco:euler" in "".join(first[:4])
    heads = next(number for number, line in enumerate(first) if line.startswith("contestant"))
    ranked = [line for line in first[heads:] if line.startswith(("tumble:", "mujoco:")) and "dt =" not in line]
    ranking = [line.split()[0] for line in ranked]
    assert len(ranking) == 6, "every contestant is ranked"
    assert short.stdout.count("dt = ") == 2, "the engine's default and the one that was named"
    assert long.stdout.count("dt = ") == 6
    assert "ns/step" not in long.stdout, "a time of one pass is no figure"


CUT = """
title = "Samples that a step of 2 ms does not reach"
duration = 2.0
samples = 13
step = 0.002
[body]
shape = "box"
size = [0.4, 0.15, 0.1]
mass = 2.4
angular_velocity = [0.2, -0.1, 0.4]
"""


def test_the_step_taken_is_said_beside_the_one_asked_for(tumble, tmp_path):
    """A thirteenth of 2 s is 76.9 steps of 2 ms: 77 are taken, 1001 in all."""
    (tmp_path / "cut.toml").write_text(CUT)
    done = tumble("compare", "cut.toml", "-e", "mujoco:rk4", "-e", "tumble:adaptive", "-o", "out")
    assert "1001 steps of 0.001998 s on average" in " ".join(done.stdout.split())
    assert "mujoco:rk4, dt = 0.002 s (0.001998 s taken), vertex" in done.stdout
    with open(tmp_path / "out/runs.csv", newline="") as file:
        runs = {row["engine"]: row for row in csv.DictReader(file)}
    assert (runs["mujoco"]["dt_s"], float(runs["mujoco"]["dt_taken_s"])) == ("0.002", 2 / 1001)
    assert runs["tumble"]["dt_taken_s"] == "", "a tolerance chose its steps"
    assert "took 1001 steps of 0.001998 s" in tumble("run", "cut.toml", "-e", "mujoco:rk4").stderr
    assert "taken" not in tumble("compare", "two-hits", "-e", "mujoco:rk4").stdout
