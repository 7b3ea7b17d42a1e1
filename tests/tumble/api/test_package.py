"""`import tumble` is quick, and its public names are those of `__all__`, with these signatures."""

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import tumble

HOME = Path(tumble.__file__)
SIGNATURES = Path(__file__).parent / "signatures.txt"
HEAVY = {
    "numpy",
    "pandas",
    "numba",
    "scipy",
    "mpmath",
    "msgspec",
    "rich",
    "trimesh",
    "jinja2",
    "tumble.scenarios.scene",
}


def python(code: str, *flags: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-P", *flags, "-c", code], capture_output=True, text=True, check=True)


def signatures() -> str:
    """Return every public function and method with its parameters, without annotations."""
    lines = []
    for name in tumble.__all__:
        found = getattr(tumble, name)
        if not inspect.isclass(found) or not issubclass(found, BaseException):
            lines.append(f"{name}{bare(found)}")
        if inspect.isclass(found):
            for method, one in inspect.getmembers(found):
                if method[0] != "_" and not hasattr(Exception, method):
                    lines.append(f"{name}.{method}{bare(one) if callable(one) else ''}")
    return "\n".join(lines) + "\n"


def bare(function: object) -> str:
    parameters = inspect.signature(function).parameters.values()
    return str(inspect.Signature([one.replace(annotation=inspect.Parameter.empty) for one in parameters]))


def test_import_loads_nothing_heavy():
    loaded = python("import sys; before = set(sys.modules); import tumble; print(*(set(sys.modules) - before))")
    names = set(loaded.stdout.split())
    assert "tumble" in names
    assert not names & HEAVY
    assert {name for name in names if name.startswith("tumble.")} == set()
    assert not {name.partition(".")[0] for name in names} - set(sys.stdlib_module_names) - {"tumble"}


def test_import_takes_a_fraction_of_importing_numpy():
    """At most 20 ms where numpy takes 80; both are measured in one process, so that load slows both."""
    lines = python("import tumble, numpy", "-X", "importtime").stderr.splitlines()
    rows = [line.removeprefix("import time:").split("|") for line in lines if line.count("|") == 2]
    cumulative_us = {row[2].strip(): int(row[1]) for row in rows[1:]}
    assert cumulative_us["tumble"] < cumulative_us["numpy"] / 4


def test_every_list_of_public_names_is_the_same():
    tree = ast.parse(HOME.read_text(encoding="utf-8"))
    (typed,) = (node for node in tree.body if isinstance(node, ast.If))
    imported = {
        alias.asname: node.module
        for node in typed.body
        if isinstance(node, ast.ImportFrom) and node.module != "typing"
        for alias in node.names
    }
    assert imported == tumble._HOMES
    assert tumble.__all__ == sorted(imported)
    assert set(tumble.__all__) <= set(dir(tumble))
    for name, home in imported.items():
        found = getattr(tumble, name)
        assert inspect.getdoc(found), name
        assert name == "compare" or found is getattr(sys.modules[home], name)


def test_a_name_that_is_not_public_is_refused_with_those_that_are():
    with pytest.raises(AttributeError, match=r"no attribute 'compere'.*compare"):
        _ = tumble.compere


def test_signatures_are_as_they_were():
    """Public from the first release on: a change here is one for docs/compatibility.md and a file in changes/."""
    assert signatures() == SIGNATURES.read_text(encoding="utf-8")


def test_every_public_function_and_method_of_a_scene_has_an_example():
    """Which tests/docs/test_examples.py runs."""
    scene = {f"Scene.{name}": one for name, one in inspect.getmembers(tumble.Scene, callable) if name[0] != "_"}
    functions = {name: getattr(tumble, name) for name in tumble.__all__ if callable(getattr(tumble, name))}
    functions = {name: one for name, one in functions.items() if not inspect.isclass(one)}
    assert [name for name, one in {**functions, **scene}.items() if ">>> " not in (inspect.getdoc(one) or "")] == []


@pytest.mark.parametrize("name", [name for name in tumble.__all__ if inspect.isfunction(getattr(tumble, name))])
def test_everything_after_two_operands_is_named(name):
    kinds = [one.kind for one in inspect.signature(getattr(tumble, name)).parameters.values()]
    assert sum(kind is inspect.Parameter.POSITIONAL_OR_KEYWORD for kind in kinds) <= 2


@pytest.mark.parametrize(
    "lines",
    [
        "import tumble; from tumble.compare.run import tasks; f = tumble.compare",
        "import tumble; f = tumble.compare; from tumble.compare.run import tasks",
        "from tumble import compare as f; import tumble.compare.run.tasks as tasks; import tumble",
        "from tumble.compare.run import tasks; import tumble; f = tumble.compare",
    ],
)
def test_compare_is_a_function_and_a_package(lines):
    code = f"""{lines}
import inspect, tumble.compare
from tumble.api.compare import compare
assert callable(f) and f is tumble.compare and tasks.__name__ == "tumble.compare.run.tasks"
assert inspect.signature(f) == inspect.signature(compare)
print(f("two-hits", "tumble:exact", film=False).runs.status.tolist())
"""
    assert python(code).stdout == "['ok']\n"
