"""An engine's own release notes, if its package ships them: they are quoted, and never decide."""

import re
from importlib.metadata import PackageNotFoundError, distribution, distributions
from pathlib import Path

from tumble.compare.run.contestant import MethodName
from tumble.compare.run.engines import registry
from tumble.compare.run.engines.environments import environments, folder

NAMES = re.compile(r"(change ?log|changes|history|release[-_ ]?notes)\.(rst|md|txt)", re.IGNORECASE)
# A heading: `Version 4.0.0 (...)`, `## 4.0.0`, `v4.0.0`; in reStructuredText the line below it is of one sign.
HEADING = re.compile(r"^(?:#+\s*)?(?:version\s+)?\[?v?(\d+(?:\.\d+)+[\w.]*)\]?\b.*$", re.IGNORECASE)
ROLE = re.compile(r":[\w:-]+:`([^`<]*?)\s*(?:<[^`]*>)?`")
LONGEST = 400


class Notes:
    """The sections of release notes by release; none if no notes are shipped."""

    def __init__(self, text: str) -> None:
        self._sections: dict[str, list[str]] = {}
        lines, own = text.splitlines(), None
        for number, line in enumerate(lines):
            found = HEADING.match(line)
            below = lines[number + 1].strip() if number + 1 < len(lines) else ""
            if found and (line.startswith("#") or (len(below) > 3 and len({*below}) == 1)):
                own = self._sections.setdefault(found.group(1), [])
            elif own is not None:
                own.append(line)

    def about(self, release: str, method: str) -> str:
        """Return the first item of a release's section that names the method as a word, in plain text."""
        name = MethodName.parse(method).name
        for item in items(self._sections.get(release, [])):
            if re.search(rf"(?<![\w-]){re.escape(name)}(?![\w-])", item, re.IGNORECASE):
                return item if len(item) <= LONGEST else f"{item[:LONGEST].rpartition(' ')[0]} ..."
        return ""


def items(lines: list[str]) -> list[str]:
    """Return the items of lists, and paragraphs, each as one line without markup."""
    found: list[list[str]] = [[]]
    for line in lines:
        if not line.strip() or re.match(r"\s*(?:[-*]|\d+\.|#\.)\s", line):
            found.append([])
        found[-1].append(re.sub(r"^\s*(?:[-*]|\d+\.|#\.)\s+", "", line).strip())
    texts = (ROLE.sub(r"\1", " ".join(parts)).replace("``", "").replace("`", "") for parts in found if parts)
    return [re.sub(r"^[0-9a-f]{7,}\s+", "", text.strip()) for text in texts if text.strip()]


def shipped_notes(engine: str) -> Notes:
    """Return the notes of the newest installed package of an engine, beside Tumble or in an environment."""
    packages = registry.package(engine).packages
    for package in packages:
        try:
            return Notes(text_of([distribution(package)]))
        except PackageNotFoundError:
            continue
    places = [place for one in environments() if one.engine == engine for place in sites(folder() / one.name)]
    found = [one for place in places for one in distributions(path=[str(place)]) if one.name in packages]
    return Notes(max((text_of([one]) for one in found), key=len, default=""))


def sites(environment: Path) -> list[Path]:
    """Return the site-packages folders of a Python environment."""
    return list(environment.glob("lib/python*/site-packages"))


def text_of(found: list) -> str:
    """Return the longest text among files of packages that are named as release notes are."""
    paths = [Path(str(file.locate())) for one in found for file in one.files or () if NAMES.fullmatch(file.name)]
    return max(
        (path.read_text(encoding="utf-8", errors="replace") for path in paths if path.is_file()), key=len, default=""
    )
