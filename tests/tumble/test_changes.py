"""The files in changes/ are what CONTRIBUTING asks for, and what `make changelog` reads."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["towncrier"]
KINDS = [kind["directory"] for kind in SETTINGS["type"]]
FRAGMENT = re.compile(rf"[a-z0-9][a-z0-9.-]*\.({'|'.join(KINDS)})\.md")


def test_every_change_has_a_name_that_is_read():
    names = {path.name for path in (ROOT / SETTINGS["directory"]).iterdir()} - set(SETTINGS["ignore"])
    assert [name for name in sorted(names) if not FRAGMENT.fullmatch(name)] == []


def test_every_change_is_a_sentence_or_two():
    for path in (ROOT / SETTINGS["directory"]).glob("*.md"):
        text = path.read_text(encoding="utf-8").strip()
        assert text.endswith((".", ")")), path.name
        assert not re.search(r"^(#|-|\*) ", text, re.MULTILINE), f"{path.name}: no headings and no list"
        assert "\n\n" not in text, f"{path.name}: one paragraph"


def test_the_changelog_has_the_place_where_changes_go():
    text = (ROOT / SETTINGS["filename"]).read_text(encoding="utf-8")
    assert text.count(SETTINGS["start_string"]) == 1
    assert text.index(SETTINGS["start_string"]) < text.index("\n## ")


def test_contributing_says_which_kinds_there_are():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    said = text[text.index("## A line in the changelog") :]
    for kind in KINDS:
        assert f"`{kind}`" in said
