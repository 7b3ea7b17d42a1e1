"""Functions of the calling program as engines: the numbers of the same function in a file, and failures as rows."""

import numpy as np
import pytest

import tumble

STEP = '''
import numpy as np

FEATURES = {"gravity"}


def step(state, dt, body):
    """Semi-implicit Euler without the gyroscopic term."""
    x, q, v, w = state[0:3], state[3:7], state[7:10], state[10:13]
    v += dt * body.gravity
    x += dt * v
    q += 0.5 * dt * np.array([-w @ q[1:], *(q[0] * w + np.cross(w, q[1:]))])
    q /= np.linalg.norm(q)
'''


@pytest.fixture
def named() -> dict:
    names: dict = {}
    exec(STEP, names)
    return names


def test_a_function_gives_what_it_gives_in_a_file_bit_for_bit(named, tmp_path):
    (tmp_path / "infile.py").write_text(STEP, encoding="utf-8")
    incell = tumble.engine(named["step"], name="incell", features={"gravity"})
    found = tumble.compare(["two-hits", "brick-tumble"], [incell, tmp_path / "infile.py"])
    tables = found.vertex_errors
    one, other = (tables[tables["engine"] == name].reset_index(drop=True) for name in ("incell", "infile"))
    assert len(one) > 100
    numbers = one.select_dtypes("number").columns
    assert {"x_m", "error_m"} <= set(numbers)
    assert one[numbers].to_numpy().tobytes() == other[numbers].to_numpy().tobytes()
    engines = found.engines.set_index("engine")
    assert "not isolated" in engines.loc["incell", "version"]
    assert "not isolated" not in str(engines.loc["infile", "version"])


def test_a_plain_function_and_an_engine_object_take_part(named):
    class Whole:
        METHODS, FEATURES, ABOUT = ("step",), {"gravity"}, {"version": "1", "precision": "double"}

        def build(self, scene, method):
            return {"states": None, "gravity": np.zeros(3) if scene.gravity is None else np.array(scene.gravity)}

        def write(self, world, states):
            world["states"] = states.copy()

        def advance(self, world, n, dt):
            for _ in range(n):
                for state in world["states"]:
                    state[7:10] += dt * world["gravity"]
                    state[0:3] += dt * state[7:10]

        def read(self, world):
            return world["states"].copy()

    def plain(state, dt, body):
        state[0:3] += dt * state[7:10]

    runs = tumble.compare(tumble.Scene.box((1, 1, 1), 1.0, duration=1.0, samples=4), [Whole(), plain]).runs
    assert dict(zip(runs["engine"], runs["status"], strict=True)) == {"Whole": "ok", "plain": "ok"}
    assert float(runs["max_error_m"].max()) < 1e-12


def test_an_exception_is_a_row_and_the_others_go_on():
    def breaks(state, dt, body):
        raise ValueError("no such thing")

    found = tumble.compare("two-hits", [tumble.engine(breaks, features={"gravity"}), "tumble:rk4"], film=False)
    runs = found.runs.set_index("engine")
    assert runs["status"].to_dict() == {"breaks": "crashed", "tumble": "ok"}
    assert "no such thing" in runs.loc["breaks", "why"]


def test_an_interrupt_in_the_function_is_the_callers():
    def interrupted(state, dt, body):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        tumble.compare("two-hits", tumble.engine(interrupted, features={"gravity"}))


def test_a_name_that_is_taken_is_refused(named):
    with pytest.raises(tumble.UserError, match="mujoco: an engine of ours"):
        tumble.engine(named["step"], name="mujoco")
    twice = [tumble.engine(named["step"], name="mine"), tumble.engine(named["step"], name="mine")]
    with pytest.raises(tumble.UserError, match="mine"):
        tumble.compare("two-hits", twice)
    with pytest.raises(tumble.UserError, match="must be ENGINE"):
        tumble.compare("two-hits", 3)


def test_the_reason_of_a_failure_is_in_the_message(monkeypatch, tmp_path):
    monkeypatch.setenv("TUMBLE_ENVIRONMENTS", str(tmp_path))
    with pytest.raises(tumble.UserError, match="physx: missing: not installed"):
        tumble.check_engine("physx")
    with pytest.raises(tumble.UserError, match=r"skipped: .*gravity"):
        tumble.run("brick-tumble", lambda state, dt, body: state)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: tumble.run("two-hits", dt=-1), "dt = -1: must be a positive number of seconds"),
        (lambda: tumble.compare("two-hits", time_limit="1"), "time_limit = '1': must be"),
        (lambda: tumble.sweep("two-hits", memory_limit=0), "memory_limit = 0: must be a positive number of bytes"),
        (lambda: tumble.run(["two-hits", "die-straight"]), "must be a scene's name"),
        (lambda: tumble.compare(None), "None: must be a scene's name"),
        (lambda: tumble.check_engine(["tumble", "mujoco"]), "must be ENGINE[:METHOD]"),
        (lambda: tumble.check_engine("tumble", only="turn"), "only = 'turn': did you mean 'turns'?"),
        (lambda: tumble.engine(3), "3: must be a function step(state, dt, body)"),  # type: ignore[call-overload]
        (lambda: tumble.engine(len, features="wings"), "len: unknown feature 'wings'"),
        (lambda: tumble.engine(len, precision="half"), "precision = 'half': must be 'double' or 'single'"),
        (lambda: tumble.grade({"t_s": [0.0]}, "two-hits", spin="bdy"), "spin = 'bdy': must be 'world' or 'body'"),
        (lambda: tumble.grade({"t_s": [0.0]}, "two-hits", like="unty"), "like = 'unty': must be 'unity' or"),
        (lambda: tumble.grade({"t_s": [0.0]}, "two-hits", start="0"), "start = '0': must be a number of seconds"),
        (lambda: tumble.grade({"t_s": [0.0]}, "two-hits", names=["t_s"]), "names: are those of a file"),
    ],
)
def test_a_value_that_cannot_be_used_is_refused_in_one_line(call, said):
    with pytest.raises(tumble.UserError) as refused:
        call()
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_dict_a_path_and_a_scene_are_the_same_question(tmp_path):
    scene = tumble.Scene.read("two-hits")
    (tmp_path / "scene.toml").write_text(scene.to_toml(), encoding="utf-8")
    given = ["two-hits", scene.to_dict(), str(tmp_path / "scene.toml"), tmp_path / "scene.toml", scene]
    errors = {tumble.compare(one, "tumble:rk4").runs["max_error_m"].iloc[0] for one in given}
    assert len(errors) == 1


def test_two_scenes_of_one_name_are_two_in_every_table():
    scene = tumble.Scene.read("two-hits")
    found = tumble.compare([scene, scene.replace(mass=3.0)], "tumble:rk4")
    for table in (found.runs, found.vertex_errors, found.scenes):
        assert list(dict.fromkeys(table["scene"])) == ["two-hits", "two-hits-2"]
    assert len(set(found.runs["max_error_m"])) == 2


def test_a_decorated_function_can_be_called_and_checked(named):
    mine = tumble.engine(features={"gravity"}, name="mine")(named["step"])
    state = np.array([0.0] * 3 + [1.0] + [0.0] * 3 + [1.0, 2.0, 3.0] + [0.0] * 3)

    class Body:
        gravity = np.zeros(3)

    mine(state, 0.5, Body)
    assert state[:3].tolist() == [0.5, 1.0, 1.5]
    assert mine.__doc__ == "Semi-implicit Euler without the gyroscopic term."
    found = tumble.check_engine(mine)
    assert set(found.table["outcome"]) <= {"passed", "failed", "skipped"}
    assert "failed" in set(tumble.check_engine(lambda state, dt, body: state).table["outcome"])
