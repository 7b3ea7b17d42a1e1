"""What `make venv` installs is pinned and hashed, down to the last package that another needs."""

import re
from importlib.metadata import requires, version
from importlib.util import find_spec
from pathlib import Path

import pytest
from packaging.markers import default_environment
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
FILES = ("requirements.txt", "requirements-lab.txt", "requirements-test.txt", "requirements-docs.txt")
# The lab's viser takes no new one: `make venv` has the newest, and the lab puts an older one in its place.
OLDER_IN_THE_LAB = "rich"


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
    if file == FILES[3] and find_spec("sphinx") is None:
        pytest.skip("the site needs `make venv-docs`")
    found = pinned((ROOT / file).read_text())
    for name, (requirement, hashes) in found.items():
        assert [one.operator for one in requirement.specifier] == ["=="], name
        assert hashes >= 1, name
        replaced = file == FILES[0] and name == OLDER_IN_THE_LAB
        if not replaced and (not requirement.marker or requirement.marker.evaluate()):
            assert requirement.specifier.contains(version(name)), f"{name} {version(name)} is installed"
    assert found["numpy"][1] > 20, "one for every platform"


def test_nothing_that_is_needed_is_left_out():
    assert needed("tumble") <= pinned((ROOT / "requirements.txt").read_text()).keys()
    assert needed("tumble", ("lab",)) <= pinned((ROOT / "requirements-lab.txt").read_text()).keys()
    for what, least in (("test", 10), ("docs", 5)):
        if what == "docs" and find_spec("sphinx") is None:
            continue
        found = pinned((ROOT / f"requirements-{what}.txt").read_text())
        listed = re.findall(r"^[\w-]+", (ROOT / f"requirements-{what}.in").read_text(), re.MULTILINE)
        assert len(listed) > least
        for name in listed:
            assert {canonicalize_name(name), *needed(name)} <= found.keys(), name


def test_the_lists_agree_and_name_no_index():
    small, middle, large, largest = texts = [(ROOT / file).read_text() for file in FILES]
    core = {name: pin for name, pin in pinned(small).items() if name != OLDER_IN_THE_LAB}
    assert core.items() <= pinned(middle).items() <= pinned(large).items() <= pinned(largest).items()
    others = [(ROOT / f"requirements-{what}.txt").read_text() for what in ("installer", "release")]
    for text in (*texts, *others):
        assert "://" not in text
        assert "index" not in text


def test_the_lab_alone_holds_rich_back():
    newest, lab = (pinned((ROOT / file).read_text())[OLDER_IN_THE_LAB][0].specifier for file in FILES[:2])
    assert not any(lab.contains(each.version) for each in newest)
    assert not any(Requirement(line).name == OLDER_IN_THE_LAB and "<" in line for line in requires("tumble") or ())


def test_what_makes_a_release_is_pinned():
    lines = (ROOT / "requirements-release.txt").read_text().splitlines()
    tools = {Requirement(line).name: Requirement(line) for line in lines if not line.startswith("#")}
    assert {"build", "check-wheel-contents", "hatchling", "towncrier", "twine"} == set(tools)
    for each in tools.values():
        assert [one.operator for one in each.specifier] == ["=="], each
    core = pinned((ROOT / "requirements.txt").read_text())
    assert core["hatchling"][0].specifier == tools["hatchling"].specifier


def test_what_installs_the_rest_is_pinned_alone():
    found = pinned((ROOT / "requirements-installer.txt").read_text())
    assert set(found) == {"uv"}
    requirement, hashes = found["uv"]
    assert [one.operator for one in requirement.specifier] == ["=="]
    assert hashes > 10, "one for every platform"


def test_the_commands_install_nothing_else():
    text = (ROOT / "Makefile").read_text()
    ways = re.findall(r"^(?:PIP|install) [:=]+ (.*)", text, re.MULTILINE)
    assert [" --no-deps" in way for way in ways] == [True, True], "ours brings nothing with it, and pins are complete"
    installs = [
        line for line in text.splitlines() if re.search(r"\$\(call install,|^\t.*(?:\$\(PIP\)|pip install)", line)
    ]
    # Ours itself has no hash: it is installed apart.  What makes lists and releases has an environment of its own.
    known = r"--require-hashes -r ([\w.-]+)|--no-build-isolation (-e) \.|(pip-tools==\S+|-r requirements-release\.txt)"
    found = [re.findall(known, line) for line in installs]
    assert all(len(each) == 1 for each in found), "each installs what is known, and that alone"
    assert sorted(one for each in found for one in each) == [
        ("", "", "-r requirements-release.txt"),
        ("", "", "pip-tools==7.6.2"),
        ("", "-e", ""),
        ("requirements-docs.txt", "", ""),
        ("requirements-installer.txt", "", ""),
        ("requirements-lab.txt", "", ""),
        ("requirements-test.txt", "", ""),
        ("requirements.txt", "", ""),
    ]
