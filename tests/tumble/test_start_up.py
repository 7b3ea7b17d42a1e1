"""A command imports only what it uses, in its own process and in the engines': what is not imported takes no time."""

import os
import re
import subprocess
import sys

import pytest
from patience import PATIENCE_S

ENGINES = {"mujoco", "pybullet", "heyoka"}
DRAWING = {"altair", "vl_convert", "jinja2", "pandas", "matplotlib"}
TRUTH = {"mpmath", "gmpy2", "tumble.scenarios.truth"}
IMPORTED = re.compile(r"^import time:.*\|\s*(\S+)$", re.MULTILINE)


def imported(*words: str, folder) -> set[str]:
    """Return the names of all modules that a command and the processes it starts have imported."""
    said = subprocess.run(
        [sys.executable, "-P", "-m", "tumble", *words],
        cwd=folder,
        env={**os.environ, "PYTHONPROFILEIMPORTTIME": "1"},
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    assert said.returncode == 0, said.stderr[-2000:]
    found = set(IMPORTED.findall(said.stderr))
    assert "tumble.__main__" in found or "tumble" in found, "the list of imports cannot be read"
    return found


@pytest.mark.parametrize(
    ("words", "used", "unused"),
    [
        (
            ["--help"],
            {"argparse"},
            {"numpy", "msgspec", "multiprocessing", "tumble.scenarios", "tumble.compare", "rich"},
        ),
        (
            ["--version"],
            {"argparse"},
            {"numpy", "msgspec", "multiprocessing", "tumble.scenarios", "tumble.compare", "rich"},
        ),
        (
            ["scenes"],
            {"tumble.scenarios.needs"},
            {
                "trimesh",
                "scipy",
                "numba",
                "numpy.ma",
                "difflib",
                "rich",
                "multiprocessing",
                "tumble.compare",
                *TRUTH,
                *DRAWING,
            },
        ),
        # A body that never turns needs no compiled loop: the compiler's own typing is what takes longest to import.
        (
            ["run", "die-straight"],
            {"tumble.solver.flight"},
            {"scipy.linalg", "numba.np.arraymath", "trimesh", "rich", *TRUTH, *ENGINES, *DRAWING},
        ),
        # The compiler would look for scipy's BLAS, which no kernel calls.
        (
            ["run", "die-vertex"],
            {"numba.core.dispatcher"},
            {"scipy.linalg", "trimesh", "rich", *TRUTH, *ENGINES, *DRAWING},
        ),
        (
            ["run", "die-vertex", "-e", "mujoco"],
            {"mujoco"},
            {"tumble.solver", "numba", "scipy", "rich", *TRUTH, *DRAWING, *ENGINES - {"mujoco"}},
        ),
        (
            ["run", "die-vertex", "-e", "pybullet"],
            {"importlib.metadata"},
            {"tumble.solver", "numba", "scipy", "rich", *TRUTH, *DRAWING, *ENGINES - {"pybullet"}},
        ),
        (["engines", "-e", "tumble"], {"rich"}, {"numba.np.arraymath", "mpmath", *ENGINES, *DRAWING}),
        (["compare", "die-straight", "-e", "tumble:rk4"], {"mpmath", "rich"}, {"trimesh", *ENGINES, *DRAWING}),
        (["compare", "die-straight", "-e", "mujoco"], {"mpmath", "mujoco"}, {"tumble.solver", "pybullet", *DRAWING}),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_a_command_imports_what_it_uses_and_no_more(words, used, unused, tmp_path):
    found = imported(*words, folder=tmp_path)
    assert used <= found
    assert not unused & found


def test_a_mesh_of_triangles_alone_needs_no_mesh_library(tmp_path):
    assert "trimesh" not in imported("run", "mesh-die", folder=tmp_path)


def test_blas_threads_are_those_asked_for_and_otherwise_one(tmp_path):
    code = "import os; from tumble.__main__ import main; main(['scenes']); print(os.environ['OPENBLAS_NUM_THREADS'])"
    environment = {key: value for key, value in os.environ.items() if key != "OPENBLAS_NUM_THREADS"}
    for asked in ({}, {"OPENBLAS_NUM_THREADS": "2"}):
        said = subprocess.run(
            [sys.executable, "-c", code], env={**environment, **asked}, cwd=tmp_path, capture_output=True, text=True
        )
        assert said.stdout.splitlines()[-1] == asked.get("OPENBLAS_NUM_THREADS", "1")


@pytest.mark.parametrize(
    ("variable", "value", "said"),
    [
        ("NUMBA_DISABLE_JIT", "1", "NUMBA_DISABLE_JIT is set, but Tumble must compile its kernels: unset it"),
        ("NUMBA_NUM_THREADS", "0", "NUMBA_NUM_THREADS = 0: must be at least 1, or unset"),
        ("NUMBA_NUM_THREADS", "-2", "NUMBA_NUM_THREADS = -2: must be at least 1, or unset"),
    ],
)
def test_an_environment_in_which_no_kernel_can_be_compiled_is_refused_in_one_line(tumble, variable, value, said):
    done = tumble("compare", "die-vertex", "-e", "tumble:rk4", env={**os.environ, variable: value})
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"tumble: {said}")
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize("asked", [("NUMBA_DISABLE_JIT", "0"), ("NUMBA_NUM_THREADS", "1"), ("NUMBA_DISABLE_JIT", "no")])
def test_other_values_do_no_harm(tumble, asked):
    done = tumble("run", "die-vertex", "-e", "tumble:rk4", env={**os.environ, **dict([asked])})
    assert done.returncode == 0, done.stderr
