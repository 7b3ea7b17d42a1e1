"""Finds refused words in text for users, those of the table at the end of docs/glossary.md.

Searched are Markdown, strings of Python and JavaScript, text of HTML, whole TOML files and starters.  Not searched are
`code`, docstrings (but those of a table's row, which `tumble columns` prints), comments, and strings without a space.
A line whose word cannot be changed ends with the comment `words: allow`.

.venv/bin/python -m tools.words [PATH ...]
"""

import ast
import os
import re
import sys
from argparse import ArgumentParser
from collections.abc import Callable, Iterable, Iterator
from html.parser import HTMLParser
from pathlib import Path

from pygments.lexers import JavascriptLexer
from pygments.token import String

ROOT = Path(__file__).parents[1]
GLOSSARY = ROOT / "docs/glossary.md"
HEADING = "## Refused words"
MADE = "generated"  # the folder in docs/ with the pages that `make docs` makes from the code
SEARCHED = ("README.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md", "changes", "docs", "tumble", "solver",
            "scenarios", "compare", "reports", "tools")  # fmt: skip
STARTERS = ROOT / "tumble/starters"
SHOWN_ATTRIBUTES = ("alt", "aria-label", "content", "placeholder", "title")
ALLOWED = "words: allow"
CODE = re.compile(
    r"(?P<fence>```|`+).*?(?P=fence)|\]\([^)\s]*\)|^(?: {4}|\t)[^\n]*$|<!--.*?-->", re.DOTALL | re.MULTILINE
)
GAP = "\N{OBJECT REPLACEMENT CHARACTER}"  # what a value of an f-string is shown as
# A text and the number of its first line.
Text = tuple[int, str]


def refused(glossary: str) -> dict[str, str]:
    """Return what to write instead of each refused word."""
    table = glossary.partition(HEADING)[2]
    rows = re.findall(r"^\| ([^|]+) \| ([^|]+) \|$", table, re.MULTILINE)[1:]
    return {word.strip(): instead for words, instead in rows for word in words.split(",")}


def pattern(words: Iterable[str]) -> re.Pattern[str]:
    """Return a pattern of the words, which finds no part of a name or of a compound such as right-handed."""
    longest_first = sorted(words, key=len, reverse=True)
    either = "|".join(re.escape(word).replace(r"\ ", r"\s+") for word in longest_first)
    return re.compile(rf"(?<![\w./-])(?:{either})(?![\w/(=-])", re.IGNORECASE)


def blanked(text: str) -> str:
    """Return Markdown with its code, comments and addresses as blanks, line by line where they were."""
    return CODE.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)


def of_markdown(source: str) -> Iterator[Text]:
    """Yield the prose; of the glossary without the table of refused words."""
    yield 1, blanked(source.partition(HEADING)[0])


def of_python(source: str) -> Iterator[Text]:
    """Yield strings with a space in them, each as one line, and docstrings of a table's rows."""
    tree = ast.parse(source)
    skipped: set[ast.AST] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            first = node.body[0] if node.body else None
            is_row = isinstance(node, ast.ClassDef) and node.name.endswith("Row")
            if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant) and not is_row:
                skipped.add(first.value)
        if isinstance(node, ast.JoinedStr):
            skipped.update(node.values)
            pieces = (str(part.value) if isinstance(part, ast.Constant) else GAP for part in node.values)
            yield from spaced(node.lineno, "".join(pieces).replace("\n", " "))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and node not in skipped:
            yield from spaced(node.lineno, node.value.replace("\n", " "))


def of_javascript(source: str) -> Iterator[Text]:
    """Yield strings and pieces of templates with a space in them."""
    line = 1
    for kind, text in JavascriptLexer(stripnl=False).get_tokens(source):
        if kind in String and kind is not String.Regex:
            yield from spaced(line, text)
        line += text.count("\n")


def spaced(line: int, text: str) -> Iterator[Text]:
    """Yield a text unless it is one word, which is a name more often than not."""
    if " " in text:
        yield line, re.sub(r"`[^`]*`", GAP, text)


class Page(HTMLParser):
    """Collects the text of a page and its attributes that are shown or read aloud."""

    def __init__(self) -> None:
        super().__init__()
        self.texts: list[Text] = []

    def handle_data(self, data: str) -> None:
        """Keep text between tags."""
        self.texts.append((self.getpos()[0], data))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Keep what attributes show."""
        self.texts += [(self.getpos()[0], text) for name, text in attrs if text and name in SHOWN_ATTRIBUTES]


def of_html(source: str) -> Iterator[Text]:
    """Yield text and shown attributes."""
    page = Page()
    page.feed(source)
    yield from page.texts


def of_all(source: str) -> Iterator[Text]:
    """Yield a file whole: one that users read, comments included."""
    yield 1, source


READERS: dict[str, Callable[[str], Iterator[Text]]] = {
    ".md": of_markdown, ".py": of_python, ".js": of_javascript, ".mjs": of_javascript, ".html": of_html,
    ".toml": of_all,
}  # fmt: skip


def files(paths: Iterable[Path]) -> Iterator[Path]:
    """Yield the files that can be searched, those of folders included; no link to a folder is followed."""
    for path in paths:
        if path.is_file():
            yield path
        for folder, inside, names in os.walk(path):
            inside[:] = [name for name in inside if name != MADE]
            yield from (Path(folder, name) for name in sorted(names) if reader(Path(folder, name)))


def reader(path: Path) -> Callable[[str], Iterator[Text]] | None:
    """Return what finds the text for users in a file, if it can hold any."""
    return of_all if path.parent == STARTERS and path.name != "__init__.py" else READERS.get(path.suffix)


def found(path: Path, words: dict[str, str]) -> Iterator[str]:
    """Yield a line for each refused word in a file."""
    read, source = reader(path), path.read_text(encoding="utf-8")
    if read is None or not (any_of := pattern(words)).search(source):
        return
    lines = source.splitlines()
    for first, text in read(source):
        for match in any_of.finditer(text):
            word = " ".join(match[0].split())
            line = first + text.count("\n", 0, match.start())
            # A Python string over several lines is one text: the word is on its first line or on one that follows.
            line = next((at for at in range(line, len(lines) + 1) if match[0].split()[0] in lines[at - 1]), line)
            if ALLOWED not in lines[line - 1]:
                yield f"{path}:{line}: {word}: write {words[word.lower()]}"


def main(paths: list[Path]) -> int:
    """Print every refused word; return 1 where there is one."""
    words = refused(GLOSSARY.read_text(encoding="utf-8"))
    problems = [problem for path in files(paths) for problem in found(path, words)]
    for problem in problems:
        sys.stdout.write(problem + "\n")
    return 1 if problems else 0


if __name__ == "__main__":
    parser = ArgumentParser(prog="tools.words", description="Find refused words in text for users; exit 1 if any.")
    parser.add_argument("path", type=Path, nargs="*", help="files or folders; default: all that users read")
    chosen: list[Path] = parser.parse_args().path
    sys.exit(main(chosen or [Path(os.path.relpath(ROOT / name)) for name in SEARCHED]))
