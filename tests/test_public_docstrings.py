"""What one top-level package imports from another says in its docstring what it takes and returns, as numpy's do."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("solver", "scenarios", "compare", "reports")
# The packages whose docstrings are complete.
DONE = ("solver", "scenarios", "compare", "reports")
SECTION = re.compile(r"^(\w+)\n-+\n(.*?)(?=^\w+\n-+\n|\Z)", re.MULTILINE | re.DOTALL)
Definition = ast.FunctionDef | ast.ClassDef


class Place(NamedTuple):
    """Where a name is defined: a module, without `tumble.`, and the name in it."""

    module: str
    name: str


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def file_of(module: str) -> Path | None:
    """Return the file of a module, or None where there is none of that name."""
    path = ROOT.joinpath(*module.split("."))
    return next((file for file in (path / "__init__.py", path.with_suffix(".py")) if file.is_file()), None)


def imports(path: Path) -> Iterator[tuple[str, Place]]:
    """Yield every name that a file imports from Tumble, and where from."""
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("tumble."):
            for alias in node.names:
                yield alias.asname or alias.name, Place(node.module.removeprefix("tumble."), alias.name)


def used(path: Path) -> Iterator[Place]:
    """Yield what a file uses of Tumble: names that it imports, and names in modules that it imports."""
    modules = {}
    for name, place in imports(path):
        if file_of(f"{place.module}.{place.name}"):
            modules[name] = f"{place.module}.{place.name}"
        else:
            yield place
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in modules:
            yield Place(modules[node.value.id], node.attr)


def definition(place: Place) -> tuple[Place, Definition] | None:
    """Return where a function or class is defined, and how; None for anything else.  Modules may pass names on."""
    path = file_of(place.module)
    if path is None:
        return None
    for node in tree(path).body:
        if isinstance(node, Definition) and node.name == place.name:
            return place, node
    passed_on = dict(imports(path))
    return definition(passed_on[place.name]) if place.name in passed_on else None


@cache
def public() -> dict[Place, Definition]:
    """Return what is imported across top-level packages."""
    found = {}
    for path in sorted(ROOT.glob("*/**/*.py")):
        home = path.relative_to(ROOT).parts[0]
        if home not in (*PACKAGES, "tumble") or path.relative_to(ROOT).parts[:2] in [
            ("tumble", each) for each in PACKAGES
        ]:
            continue
        for place in used(path):
            if place.module.partition(".")[0] not in (home, "") and (there := definition(place)):
                found[there[0]] = there[1]
    # The annotations of a table's row state what its columns mean.
    found = {place: node for place, node in found.items() if not place.name.endswith("Row")}
    return {place: node for place, node in found.items() if place.module.partition(".")[0] in PACKAGES}


def parameters(node: Definition) -> list[str]:
    """Return the parameters of a function, or of a class's constructor: its own, or its annotated fields."""
    if isinstance(node, ast.ClassDef):
        own = next((one for one in node.body if isinstance(one, ast.FunctionDef) and one.name == "__init__"), None)
        if own is None:
            fields = (
                one.target.id
                for one in node.body
                if isinstance(one, ast.AnnAssign) and isinstance(one.target, ast.Name)
            )
            return [name for name in fields if not name.startswith("_")]
        node = own
    takes = node.args
    each = [
        *takes.posonlyargs,
        *takes.args,
        *filter(None, [takes.vararg]),
        *takes.kwonlyargs,
        *filter(None, [takes.kwarg]),
    ]
    return [one.arg for one in each if one.arg != "self"]


def returns(node: Definition) -> bool:
    """Whether a function returns something."""
    if isinstance(node, ast.ClassDef) or node.returns is None:
        return False
    return not (isinstance(node.returns, ast.Constant) and node.returns.value is None)


def lacking(node: Definition) -> list[str]:
    """Return what the docstring does not have."""
    sections = dict(SECTION.findall(ast.get_docstring(node) or ""))
    told = sections.get("Parameters", "") + sections.get("Attributes", "")
    named = {
        name.strip(" *")
        for line in re.findall(r"^[*\w].*$", told, re.MULTILINE)
        for name in line.partition(":")[0].split(",")
    }
    missing = [f"parameter {name}" for name in parameters(node) if name not in named]
    return missing + (["Returns"] if returns(node) and not {"Returns", "Yields"} & {*sections} else [])


@pytest.mark.parametrize("package", DONE)
def test_what_other_packages_import_says_what_it_takes_and_returns(package):
    found = {place: lacking(node) for place, node in public().items() if place.module.partition(".")[0] == package}
    assert len(found) > 10, "nothing is found"
    wrong = [f"{place.module}.{place.name} has no {', '.join(each)}" for place, each in sorted(found.items()) if each]
    assert not wrong, "\n".join(wrong)
