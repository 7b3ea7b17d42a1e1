"""Pages of the documentation site that are read from the code: commands, tables, engines and the Python API."""

import argparse
import ast
import csv
import inspect
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import tumble
from tumble import testing
from tumble.compare.engines import CHECKS, CONTACT_CHECKS, EULER, FINDINGS, GYROSCOPIC_NAMES, SCHEME_NAMES
from tumble.compare.run.engines import registry
from tumble.compare.run.engines.registry import EngineInfo
from tumble.compare.run.running_engines import launched
from tumble.compare.tables.known import tables
from tumble.compare.tables.schema import Table
from tumble.examples import EXAMPLES
from tumble.parser import parser

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
FAULTS = Path(__file__).with_name("engine-faults.toml")
RECORD = ROOT / "tests" / "golden"
# What an engine's file states, shown where the engine itself is not installed.
STATED = ("METHODS", "FORCED", "ON_REQUEST", "FEATURES", "GYROSCOPIC", "ORDERS", "PINS")
Row = Sequence[str]


def write_pages(folder: Path) -> None:
    """Write every generated page that is not as it was; remove those that are no longer made.

    Parameters
    ----------
    folder : created where it does not exist; nothing else may lie in it.
    """
    pages = {"commands.md": commands_page(), "tables.md": tables_page(), "api.md": api_page()}
    pages |= {"background.md": background_page(DOCS), **engine_pages()}
    for old in folder.rglob("*.md"):
        if str(old.relative_to(folder)) not in pages:
            old.unlink()
    for name, text in pages.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def table_text(head: Row, rows: Sequence[Row]) -> str:
    """Return a Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines) + "\n"


def shell(*commands: str) -> str:
    """Return commands to copy."""
    return "\n".join(("```sh", *commands, "```\n"))


# Commands


def commands_page() -> str:
    """Return the page of all commands, from the parser."""
    top = parser()
    (commands,) = (action for action in top._actions if isinstance(action, argparse._SubParsersAction))
    helps = {action.dest: action.help or "" for action in commands._choices_actions}
    parts = [
        "# Commands\n",
        "`tumble COMMAND --help` prints the same. Results go to standard output; progress and notes to standard error. "
        "Exit code 0: done; 1: a check failed; 2: your input needs a change; 3: a bug in Tumble.\n",
        table_text(
            ("command", "what it does"), [(f"[`tumble {name}`](#tumble-{name})", helps[name]) for name in helps]
        ),
    ]
    for name, command in commands.choices.items():
        usage = " ".join(command.format_usage().removeprefix("usage: ").split())
        parts += [f"(tumble-{name})=\n## tumble {name}\n", f"{sentence(helps[name])}\n", f"```text\n{usage}\n```\n"]
        parts.append(table_text(("argument", "meaning"), list(arguments(command))))
        if name in EXAMPLES:
            parts.append(shell(*EXAMPLES[name]))
    return "\n".join(parts)


def arguments(command: argparse.ArgumentParser) -> Iterator[Row]:
    """Yield the arguments of a command, each with its meaning."""
    for action in command._actions:
        if isinstance(action, argparse._HelpAction):
            continue
        value = str(action.metavar or "") if action.nargs != 0 else ""
        if action.choices and not action.metavar:
            value = "{" + ",".join(map(str, action.choices)) + "}"
        names = ", ".join(f"`{' '.join((name, value)).strip()}`" for name in action.option_strings)
        yield names or f"`{value}`", (action.help or "") % {**vars(action), "prog": command.prog}


def sentence(text: str) -> str:
    """Return a text that begins with a capital and ends with a point."""
    return text[:1].upper() + text[1:].rstrip(".") + "."


# Tables


def tables_page() -> str:
    """Return the page of all tables, from their schemas."""
    known = sorted(tables().values(), key=lambda table: table.file)
    parts = [
        "# Tables\n",
        "Commands with `-o DIR` write these tables as CSV: the first line is the header, numbers have the shortest "
        "digits that read back to the same double, and an empty cell is a value that does not exist. "
        "`datapackage.json` beside them has the same descriptions for programs "
        "([Frictionless Data Package](https://datapackage.org/standard/)); "
        "`--parquet` writes the tables as Parquet too. `tumble columns TABLE` prints one of the sections below.\n",
        table_text(("file", "one row is"), [(f"[`{each.file}`](#{anchor(each)})", each.meaning) for each in known]),
    ]
    for table in known:
        parts += [f"({anchor(table)})=\n## {table.file}\n", f"{table.meaning}\n"]
        if table.key:
            parts.append(f"Key: {', '.join(f'`{name}`' for name in table.key)}.\n")
        rows = [(f"`{each.name}`", each.kind.__name__, each.unit, each.meaning) for each in table.columns]
        parts.append(table_text(("column", "type", "unit", "meaning"), rows))
    return "\n".join(parts)


def anchor(table: Table) -> str:
    """Return the name of a table's section."""
    return f"table-{table.file.removesuffix('.csv')}"


# Engines


def engine_pages() -> dict[str, str]:
    """Return the pages of all engines, from their files, the accepted record and engine-faults.toml."""
    faults = tomllib.loads(FAULTS.read_text(encoding="utf-8"))
    record = list(csv.DictReader((RECORD / "cells.csv").read_text(encoding="utf-8").splitlines()))
    pages, rows = {}, []
    with launched(registry.names(), time_limit=300.0) as engines:
        for engine in engines:
            info = engine.info if isinstance(engine.info, EngineInfo) else None
            name = engine.title
            pages[f"engines/{name}.md"] = engine_page(name, info, faults.get(name, []), record)
            rows.append((f"[{name}]({name}.md)", summary(name), (info.precision if info else "") or "unknown"))
    toctree = "\n".join(("```{toctree}", ":hidden:", *sorted(Path(page).stem for page in pages), "```\n"))
    intro = (
        "# Engines\n\nEvery page states what Tumble knows about one engine, and ends with the commands that show it. "
        "Each engine runs with its best settings: what the scene does not need is switched off, and the page lists "
        "what that is. A name with `+defaults` is the same method with every setting as the engine ships it.\n"
    )
    pages["engines/index.md"] = "\n".join((intro, table_text(("engine", "what it is", "precision"), rows), toctree))
    return pages


def engine_page(name: str, info: EngineInfo | None, faults: list[dict[str, str]], record: list[dict[str, str]]) -> str:
    """Return the page of one engine; info: None where it is not installed."""
    package = registry.package(name)
    parts = [f"# {name}\n", f"{summary(name)}\n"]
    if package.pins:
        install = shell(f"tumble engines --install {name}") if package.apart else ""
        parts += [f"Package: {', '.join(f'`{pin}`' for pin in package.pins)}.\n", install]
    if info is None:
        parts.append("This engine was not installed where these pages were built; its file states:\n")
        parts.append(table_text(("name", "value"), [(key, value) for key, value in literals(name).items()]))
    else:
        parts += list(stated(name, info, record))
    if faults:
        parts.append("## Silent faults\n")
        parts.append("What this engine does without an error or a warning, and the command that shows it.\n")
        for fault in faults:
            parts += [f"{fault['what']}\n", shell(fault["show"])]
    parts += ["## See for yourself\n", shell(*shows(name, info))]
    return "\n".join(part for part in parts if part)


def stated(name: str, info: EngineInfo, record: list[dict[str, str]]) -> Iterator[str]:
    """Yield the parts that the engine's own file states, and what was measured."""
    yield f"Version {info.version or 'unknown'}, {info.precision or 'unknown'} precision. Forces it can express: " + (
        f"{', '.join(sorted(info.features)) or 'none'}.\n"
    )
    yield "## Methods\n"
    rows = []
    for method in (*info.methods, *info.forced, *info.on_request):
        marks = [word for word, of in (("default", info.default), ("forced scenes only", info.forced)) if method in of]
        marks += ["on request"] if method in info.on_request else []
        gyroscopic = info.gyroscopic.get(method, info.gyroscopic.get(method.partition("+")[0], ""))
        order = info.orders.get(method, EULER.get(gyroscopic))
        claimed = "" if order is None else f"{order:g}"
        cost = f"{info.step_of(method) / 1000:g}"
        rows.append((f"`{method}`", ", ".join(marks), gyroscopic, claimed, measured(name, method, record), cost))
    head = ("method", "takes part", "gyroscopic term", "order stated", "order measured", "one step about, us")
    yield table_text(head, rows)
    used = sorted({row[2] for row in rows if row[2] in GYROSCOPIC_NAMES})
    if used:
        yield "Gyroscopic term: " + "; ".join(f"*{each}*: {GYROSCOPIC_NAMES[each]}" for each in used) + ".\n"
    yield (
        "The measured order is that of the attitude on a free body that tumbles, from the accepted record in "
        "`tests/golden`. An empty cell was not measured there. A step's cost is a round figure for one body; "
        "`tumble sweep` measures it on your machine.\n"
    )
    schemes = {method: scheme for method, scheme in info.schemes.items() if scheme in SCHEME_NAMES}
    if schemes:
        yield "## With a stiff force\n"
        yield table_text(("method", "one step"), [(f"`{key}`", SCHEME_NAMES[value]) for key, value in schemes.items()])
    for title, items in (("Switched off to be fair", info.switched_off), ("As it ships", info.defaults)):
        if items:
            yield f"## {title}\n"
            yield "\n".join(f"- {item}" for item in items) + "\n"
    if info.largest_turn is not None:
        yield f"One step turns a body by at most {info.largest_turn:.4g} rad.\n"


def measured(name: str, method: str, record: list[dict[str, str]]) -> str:
    """Return the attitude order of a method on the scenes of the record that tumble freely, '' where none was found."""
    found = [
        float(row["attitude_order"])
        for row in record
        if (row["engine"], row["method"]) == (name, method) and row["scene"] in ("two-hits", "yardstick")
        if row["attitude_order"]
    ]
    return " to ".join(sorted({f"{order:.1f}" for order in (min(found), max(found))})) if found else ""


def shows(name: str, info: EngineInfo | None) -> Iterator[str]:
    """Yield the commands that show what a page states."""
    free = info is None or not info.instants
    yield f"tumble engines -e {name}                        # version, methods, what is switched off"
    yield f"tumble engines --check {name}                   # does it satisfy the engine contract?"
    if free:
        yield f"tumble compare brick-tumble -e {name}           # error, energy and momentum on a tumbling brick"
        yield f"tumble sweep yardstick -e {name} -o cost        # order of convergence, and run time for an error"
    if info and (shipped := [method for method in info.on_request if method.endswith("+defaults")]):
        yield f"tumble compare brick-tumble -e {name}:{shipped[0]}  # the same with every setting as shipped"


def summary(name: str) -> str:
    """Return the first line of an engine's file."""
    if path := registry.own_program(name):
        return sentence(path.read_text(encoding="utf-8").partition("\n")[0].lstrip("# "))
    doc = ast.get_docstring(ast.parse((ROOT / "compare" / "engines" / f"{name}.py").read_bytes())) or name
    return sentence(doc.partition("\n\n")[0].replace("\n", " "))


def literals(name: str) -> dict[str, str]:
    """Return the names that an engine's file states as plain values, read without importing it."""
    found = {}
    for line in ast.parse((ROOT / "compare" / "engines" / f"{name}.py").read_bytes()).body:
        if isinstance(line, ast.Assign) and getattr(line.targets[0], "id", "") in STATED:
            found[f"`{ast.unparse(line.targets[0])}`"] = f"`{ast.unparse(line.value)}`"
    return found


# The Python API


def api_page() -> str:
    """Return the page of the public names of `import tumble`, which autodoc fills, and of the engine contract."""
    names: Sequence[str] = getattr(tumble, "__all__", ())
    parts = [
        "# Python API\n",
        "`import tumble` has one function for each command, with the same words, defaults and results.\n"
        if names
        else "Tumble is used through its [commands](commands.md); engine files are the Python interface.\n",
    ]
    kinds: Mapping[str, Callable[[object], bool]] = {
        "autoclass": lambda each: isinstance(each, type) and not issubclass(each, BaseException),
        "autoexception": lambda each: isinstance(each, type) and issubclass(each, BaseException),
        "autofunction": lambda each: not isinstance(each, type),
    }
    for title, kind in (("Functions", "autofunction"), ("Classes", "autoclass"), ("Errors", "autoexception")):
        own = [name for name in names if kinds[kind](getattr(tumble, name))]
        if own:
            parts += [f"## {title}\n", "```{eval-rst}", ".. py:currentmodule:: tumble\n"]
            parts += [f".. {kind}:: tumble.{name}" + "\n   :members:\n" * (kind == "autoclass") for name in own]
            parts.append("```\n")
    parts += [
        "## In pytest\n",
        "pytest loads `tumble.testing` as a plugin. "
        "The [engine author's guide](/guides/engine-author.md) has a test file to copy.\n",
        "```{eval-rst}",
        ".. autofunction:: tumble.testing.parametrize_with_laws\n",
        ".. py:function:: tumble_check(scenes, contestants, **options)\n",
        f"   {inspect.getdoc(testing.tumble_check)}".replace("\n", "\n   "),
        "```\n",
        "`pytest --tumble-accept` writes the baselines of `tumble_check`; the tests still fail.\n",
    ]
    contract = (ast.get_docstring(ast.parse((ROOT / "compare/engines/__init__.py").read_bytes())) or "").strip()
    parts += [
        "## The engine file\n",
        "What a Python file states to take part as `-e ./mine.py`. The shortest has one function, "
        "`step(state, dt, body)`; `tumble engines --template python` writes one to begin with.\n",
        f"```text\n{contract}\n```\n",
        "### Checks of `tumble engines --check`\n",
        table_text(
            ("check", "what must hold"), [(f"`{name}`", what) for name, what in (CHECKS | CONTACT_CHECKS).items()]
        ),
        "### Findings of `audit`\n",
        table_text(("kind", "meaning"), [(f"`{name}`", what) for name, what in FINDINGS.items()]),
    ]
    return "\n".join(parts)


# Background


def background_page(docs: Path) -> str:
    """Return the list of the pages that lie flat in docs/, with their titles."""
    pages = sorted(path for path in docs.glob("*.md") if path.stem != "index")
    releases = sorted(docs.glob("releases/*/*.md"))
    lines = [f"- {{doc}}`/{path.relative_to(docs).with_suffix('')}`" for path in (*pages, *releases)]
    toctree = [f"/{path.relative_to(docs).with_suffix('')}" for path in (*pages, *releases)]
    return "\n".join(("# Reference pages\n", *lines, "\n```{toctree}", ":hidden:", *toctree, "```\n"))
