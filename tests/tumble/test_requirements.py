"""What `make venv` installs is pinned and hashed, down to the last package that another needs."""

import re
from importlib.metadata import requires, version
from pathlib import Path

import pytest
from packaging.markers import default_environment
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
FILES = ("requirements.txt", "requirements-lab.txt", "requirements-test.txt")


def pinned(text: str) -> dict[str, tuple[Requirement, int]]:
    """Each package of a requirements file: what is required, and how many files of it are known by their hash."""
    lines = [line for line in text.replace("\\\n", " ").splitlines() if line.strip() and not line.startswith("#")]
    found = {}
    for line in lines:
        words, *hashes = line.split(" --hash=")
        assert all(re.fullmatch(r"sha256:[0-9a-f]{64}\s*", each) for each in hashes), line
        requirement = Requirement(words.strip())
        found[canonicalize_name(requirement.name)] = requirement, len(hashes)
    return found


def needed(name: str, extras: tuple[str, ...] = ()) -> set[str]:
    """The packages that one which is installed here needs, with what those need."""
    found: set[str] = set()
    left = [(name, extras)]
    while left:
        name, extras = left.pop()
        for line in requires(name) or ():
            requirement = Requirement(line)
            told = [default_environment() | {"extra": extra} for extra in ("", *extras)]
            other = canonicalize_name(requirement.name)
            if other not in found and any(not requirement.marker or requirement.marker.evaluate(each) for each in told):
                found.add(other)
                left.append((other, tuple(requirement.extras)))
    return found


@pytest.mark.parametrize("file", FILES)
def test_every_package_is_pinned_with_its_hashes(file):
    found = pinned((ROOT / file).read_text())
    for name, (requirement, hashes) in found.items():
        assert [one.operator for one in requirement.specifier] == ["=="], name
        assert hashes >= 1, name
        if not requirement.marker or requirement.marker.evaluate():
            assert requirement.specifier.contains(version(name)), f"{name} {version(name)} is installed"
    assert found["numpy"][1] > 20, "one for every platform"


def test_nothing_that_is_needed_is_left_out():
    assert needed("tumble") <= pinned((ROOT / "requirements.txt").read_text()).keys()
    assert needed("tumble", ("lab",)) <= pinned((ROOT / "requirements-lab.txt").read_text()).keys()
    tests = pinned((ROOT / "requirements-test.txt").read_text())
    listed = re.findall(r"^[\w-]+", (ROOT / "requirements-test.in").read_text(), re.MULTILINE)
    assert len(listed) > 10
    for name in listed:
        assert {canonicalize_name(name), *needed(name)} <= tests.keys(), name


def test_the_three_agree_and_name_no_index():
    small, middle, large = ((ROOT / file).read_text() for file in FILES)
    assert pinned(small).items() <= pinned(middle).items() <= pinned(large).items()
    assert "://" not in small + middle + large
    assert "index" not in small + middle + large


def test_the_commands_install_nothing_else():
    installs = [line for line in (ROOT / "Makefile").read_text().splitlines() if "pip install" in line]
    # Ours itself has no hash: it is installed apart, and brings nothing with it.
    assert sorted(re.findall(r"--require-hashes -r (\S+)|--no-deps (-e) \.|(pip-tools==\S+)", "\n".join(installs))) == [
        ("", "", "pip-tools==7.6.2"),
        ("", "-e", ""),
        ("requirements-lab.txt", "", ""),
        ("requirements-test.txt", "", ""),
        ("requirements.txt", "", ""),
    ]
