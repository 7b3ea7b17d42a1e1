"""The words of the command line: every command, its options, what they allow, and the nearest word to a wrong one."""

import argparse
import math
import re
import sys
import textwrap
from typing import NoReturn

from tumble.examples import epilog
from tumble.starters import STARTERS

EXIT_USER = 2  # the user's mistake
AT_ONCE = ("scenes", "columns")  # commands that have no progress to report
SHELLS = ("bash", "zsh", "fish")
SCENE_HELP = "a scene of the catalogue (see `tumble scenes`) or the path of a TOML file"
ENGINE_HELP = (
    "ENGINE[@RELEASE][:METHOD] or your own engine, ./mine.py[:METHOD] or ./mine.toml[:METHOD]; may be repeated"
)
MEMORY_HELP = "for each engine's process [GiB]; default 4"


# A number and what may stand behind it for its unit; a bare one is in metres.
LENGTH = re.compile(r"(.*?[\d.])\s*([a-zµμ]*)", re.IGNORECASE)
METRES = {
    "": 1.0, "m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9, "pm": 1e-12,
    "km": 1e3, "in": 0.0254, "ft": 0.3048,
}  # fmt: skip


class Parser(argparse.ArgumentParser):
    """Refuses in one line."""

    def _check_value(self, action: argparse.Action, value: object) -> None:
        """Refuse a word that is none of those there are, and offer the nearest."""
        if action.choices is not None and value not in action.choices:
            from tumble.scenarios.format import nearest

            raise argparse.ArgumentError(action, f"{value!r}: {nearest(str(value), [*map(str, action.choices)])}")

    def error(self, message: str) -> NoReturn:
        """End with exit code 2."""
        print(f"{self.prog}: {message}; see `{self.prog} --help`", file=sys.stderr)  # noqa: T201
        sys.exit(EXIT_USER)


def positive(text: str, unit: str) -> float:
    """Return a positive number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of {unit} > 0")
    return value


def instant(text: str) -> float:
    """Return a time [s], before zero or after it."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of seconds")
    return value


def seconds(text: str) -> float:
    """Return a positive number of seconds."""
    return positive(text, "seconds")


def gibibytes(text: str) -> int:
    """Return a positive number of GiB in bytes."""
    return round(positive(text, "GiB") * 2**30)


def port(text: str) -> int:
    """Return the number of a port."""
    if not (text.isdecimal() and int(text) < 2**16):
        raise argparse.ArgumentTypeError(f"{text!r} is not the number of a port, 0 to 65535")
    return int(text)


def metres(text: str) -> float:
    """Return a positive number of metres, from a length with its unit or a bare number of metres."""
    match = LENGTH.fullmatch(text.strip())
    unit = match[2] if match else ""
    if match is None or unit not in METRES:
        raise argparse.ArgumentTypeError(f"{text!r} is not a length > 0, such as 0.001, 1mm or 50um")
    try:
        value = float(match[1]) * METRES[unit]
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError(f"{text!r} is not a length > 0, such as 0.001, 1mm or 50um")
    return value


def parser() -> Parser:
    """Return the parser of all commands."""
    top = Parser(
        prog="tumble",
        description="Throw the same die in every engine; know which one is wrong, by how much, and why.",
    )
    top.add_argument("--version", action="store_true", help="print the version and end")
    top.add_argument("--completion", choices=SHELLS, help="print what makes this shell complete tumble's words")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", parser_class=Parser)

    def command(name: str, what: str) -> argparse.ArgumentParser:
        made = commands.add_parser(
            name,
            help=what,
            description=textwrap.fill(what, 80),
            epilog=epilog(name),
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        if name not in AT_ONCE:
            made.add_argument("-q", "--quiet", action="store_true", help="report no progress on standard error")
        return made

    def contest_options(to: argparse.ArgumentParser) -> None:
        to.add_argument("-e", "--engine", action="append", default=[], metavar="ENGINE[:METHOD]", help=ENGINE_HELP)
        to.add_argument("--dt", type=seconds, metavar="S", help="step [s]; default: the scene's own")
        to.add_argument("--time-limit", type=seconds, default=60.0, metavar="S", help="for each flight [s]; default 60")
        to.add_argument("--memory-limit", type=gibibytes, default=4 << 30, metavar="GIB", help=MEMORY_HELP)

    def figure_options(to: argparse.ArgumentParser) -> None:
        to.add_argument("--svg", metavar="FILE", help="also save the figure; needs `pip install '.[figures]'`")
        to.add_argument("--png", metavar="FILE", help="the same, as PNG")

    def parquet_option(to: argparse.ArgumentParser) -> None:
        to.add_argument("--parquet", action="store_true", help="also write the tables as Parquet; needs pyarrow and -o")

    scenes = command("scenes", "list the catalogue with what each scene needs, or print a scene of it")
    scenes.add_argument(
        "scene",
        nargs="?",
        metavar="NAME",
        help="print this scene's TOML, to copy and change; of your own file also mass, volume, centre and moments",
    )
    engines = command("engines", "list the engines: versions, methods, precision, what is missing and why")
    engines.add_argument("-e", "--engine", action="append", default=[], metavar="ENGINE", help=ENGINE_HELP)
    engines.add_argument("--install", nargs="+", default=[], metavar="ENGINE[@RELEASE]", help="in an environment each")
    engines.add_argument("--remove", nargs="+", default=[], metavar="ENGINE[@RELEASE]", help="such environments")
    engines.add_argument("--check", nargs="+", metavar="ENGINE", help="put every law of engines to these")
    engines.add_argument("--time-limit", type=seconds, default=60.0, metavar="S", help="for each law [s]; default 60")
    engines.add_argument(
        "--template",
        choices=(*STARTERS,),
        metavar="LANGUAGE",
        help="write an engine to begin with, in this language, into the current folder: cpp, js, rust, csharp, python",
    )

    run = command("run", "fly one scene in one engine and give its trajectory as CSV")
    run.add_argument("scene", metavar="SCENE", help=SCENE_HELP)
    contest_options(run)
    run.add_argument("-o", "--output", metavar="FILE", help="default: standard output")

    compare = command("compare", "hold every engine against the truth: an error table for each, as in Table 4.1")
    compare.add_argument("scene", nargs="+", metavar="SCENE", help=SCENE_HELP)
    contest_options(compare)
    compare.add_argument("--all", action="store_true", help="tables of every method, not of each engine's first alone")
    compare.add_argument(
        "--vertex", type=int, metavar="K", help="vertex to print; default: where the engines stray most"
    )
    compare.add_argument("-o", "--output", metavar="DIR", help="also write all tables, every vertex, as CSV into DIR")
    parquet_option(compare)
    figure_options(compare)

    sweep = command("sweep", "error against run time: every contestant over a ladder of steps or tolerances")
    sweep.add_argument("scene", nargs="*", metavar="SCENE", help=SCENE_HELP + "; default: yardstick")
    sweep.add_argument("-e", "--engine", action="append", default=[], metavar="ENGINE[:METHOD]", help=ENGINE_HELP)
    sweep.add_argument("--reference", default="tumble:rk4", metavar="ENGINE:METHOD", help="of ratios; %(default)s")
    sweep.add_argument("--time-limit", type=seconds, default=60.0, metavar="S", help="for each flight [s]; default 60")
    sweep.add_argument("--memory-limit", type=gibibytes, default=4 << 30, metavar="GIB", help=MEMORY_HELP)
    sweep.add_argument("-o", "--output", metavar="DIR", help="also write the tables as CSV into DIR")
    parquet_option(sweep)
    figure_options(sweep)

    advise = command("advise", "the cheapest engine, method and step that stays within an error")
    advise.add_argument("scene", nargs="+", metavar="SCENE", help=SCENE_HELP)
    advise.add_argument(
        "--tolerance", type=metres, required=True, metavar="M", help="largest vertex error: 1mm, or 0.001 for metres"
    )
    advise.add_argument(
        "--beyond-samples",
        action="store_true",
        help="also try fixed steps longer than the samples are apart, and judge them where they end; methods that "
        "choose their own steps stop at every sample all the same",
    )
    advise.add_argument("-e", "--engine", action="append", default=[], metavar="ENGINE[:METHOD]", help=ENGINE_HELP)
    advise.add_argument("--time-limit", type=seconds, default=60.0, metavar="S", help="for each flight [s]; default 60")
    advise.add_argument("--memory-limit", type=gibibytes, default=4 << 30, metavar="GIB", help=MEMORY_HELP)

    stability = command("stability", "who is stable where, how long a step each bears, and what extreme cases do")
    extreme = ", or an extreme case (spin-1e4, far-1e7, denormal ...); default: stiff scenes and all extreme cases"
    stability.add_argument("scene", nargs="*", metavar="SCENE", help=SCENE_HELP + extreme)
    stability.add_argument("-e", "--engine", action="append", default=[], metavar="ENGINE[:METHOD]", help=ENGINE_HELP)
    stability.add_argument(
        "--time-limit", type=seconds, default=20.0, metavar="S", help="for each flight [s]; default 20"
    )
    stability.add_argument("--memory-limit", type=gibibytes, default=4 << 30, metavar="GIB", help=MEMORY_HELP)
    stability.add_argument("-o", "--output", metavar="DIR", help="keep the tables in DIR as CSV, and go on from there")
    parquet_option(stability)
    figure_options(stability)

    grade = command("grade", "find the error of a trajectory that another program wrote, and its most likely cause")
    grade.add_argument(
        "file",
        metavar="FILE",
        help="trajectory with one row a time: CSV, JSON lines or Parquet; - is standard input",
    )
    grade.add_argument("--scene", required=True, metavar="SCENE", help=SCENE_HELP)
    grade.add_argument(
        "--map",
        action="append",
        default=[],
        metavar="COLUMN=NAME",
        help="name of a column, with its unit: t_s, t_ms, x_cm, qw, r11, vx_m_s, wx_deg_s, v0x_m, ..., or ignore",
    )
    grade.add_argument(
        "--map-file", metavar="TOML", help="names of columns, in a table [columns] (default: FILE.toml, if it exists)"
    )
    grade.add_argument(
        "--like",
        choices=("unity", "unreal", "blender", "godot", "ros", "mujoco"),
        help="read the file as this program writes it: sets columns, units, axes, angles, start and decimal sign, "
        "and prints the options that do so",
    )
    grade.add_argument(
        "--by", choices=("pose", "matrix", "vertices"), help="description of the pose to grade, if the file has several"
    )
    grade.add_argument("--columns", metavar="NAME,...", help="names of the columns of a file without a header")
    grade.add_argument(
        "--start", type=instant, metavar="S", help="what the file's clock shows at the scene's start [s] (default: 0)"
    )
    grade.add_argument(
        "--euler",
        metavar="ORDER",
        help="convention of the angles rx, ry, rz: unity, unreal, blender, godot, ros, mujoco, or the order of "
        "rotations: zxy about fixed axes, ZXY about the body's",
    )
    grade.add_argument(
        "--axes",
        metavar="NAME",
        help="axes of the file: unity, unreal, blender, godot, ros, mujoco, or those that are our x, y, z: x,y,-z",
    )
    grade.add_argument(
        "--spin", choices=("world", "body"), default="world", help="axes of the angular velocity (default: world)"
    )
    grade.add_argument("--decimal", choices=(".", ","), default=".", help="decimal sign; default: a point")
    grade.add_argument(
        "--tolerance", type=metres, metavar="M", help="exit 1 if a vertex error is larger: 1mm, or 0.001 for metres"
    )
    grade.add_argument("--json", action="store_true", help="print the grade as JSON")
    grade.add_argument("-o", "--output", metavar="DIR", help="also write the tables as CSV into DIR")
    parquet_option(grade)

    check = command("check", "hold errors, orders, energy and run times against a record: exit 1 if any is worse")
    check.add_argument("scene", nargs="*", metavar="SCENE", help=SCENE_HELP + "; default: the record's, or all")
    check.add_argument("-e", "--engine", action="append", default=[], metavar="ENGINE[:METHOD]", help=ENGINE_HELP)
    check.add_argument("--accept", action="store_true", help="record into -o DIR; exit 1 where that changes a record")
    check.add_argument("--accept-failures", action="store_true", help="record what crashed, hung or is missing, too")
    check.add_argument("--baseline", metavar="DIR", help="the record to compare with")
    check.add_argument("--trust", action="store_true", help="run the engine files that the record names, too")
    check.add_argument("--candidate", metavar="DIR", help="another record to hold against it; nothing is flown")
    check.add_argument("-o", "--output", metavar="DIR", help="write the new record, summary.md and junit.xml into DIR")
    parquet_option(check)
    check.add_argument("--tolerances", metavar="FILE.toml", help="what each column may change by")
    check.add_argument("--no-times", action="store_true", help="record no run times; for machines that share nothing")
    check.add_argument("--time-limit", type=seconds, default=60.0, metavar="S", help="for each flight [s]; default 60")
    check.add_argument("--memory-limit", type=gibibytes, default=4 << 30, metavar="GIB", help=MEMORY_HELP)

    ablate = command("ablate", "what leaving out pays: every contestant with and without what a scene has no use for")
    ablate.add_argument("scene", nargs="*", metavar="SCENE", help=SCENE_HELP + "; default: three that need little")
    ablate.add_argument("-e", "--engine", action="append", default=[], metavar="ENGINE[:METHOD]", help=ENGINE_HELP)
    ablate.add_argument("--time-limit", type=seconds, default=60.0, metavar="S", help="for each flight [s]; default 60")
    ablate.add_argument("--memory-limit", type=gibibytes, default=4 << 30, metavar="GIB", help=MEMORY_HELP)
    ablate.add_argument("-o", "--output", metavar="DIR", help="also write the tables as CSV into DIR")
    parquet_option(ablate)

    releases = command("releases", "what changed between an engine's releases, found from the numbers")
    releases.add_argument("engine", metavar="ENGINE", help="an engine with releases of its own (see `tumble engines`)")
    releases.add_argument("scene", nargs="*", metavar="SCENE", help=SCENE_HELP + "; default: three that tell most")
    releases.add_argument("--from", dest="first", metavar="RELEASE", help="leave out those before this one")
    releases.add_argument("--to", dest="last", metavar="RELEASE", help="leave out those after this one")
    releases.add_argument(
        "--install", action="store_true", help="first install, in an environment each, what the package index has"
    )
    releases.add_argument(
        "--time-limit", type=seconds, default=60.0, metavar="S", help="for each flight [s]; default 60"
    )
    releases.add_argument("--memory-limit", type=gibibytes, default=4 << 30, metavar="GIB", help=MEMORY_HELP)
    releases.add_argument("-o", "--output", metavar="DIR", help="keep CSV and Markdown in DIR, and go on from there")
    parquet_option(releases)

    lab = command("lab", "click the die in a browser, and watch all engines fly against the truth")
    lab.add_argument("scene", nargs="?", default="die-ray", metavar="SCENE", help=SCENE_HELP + "; default: %(default)s")
    lab.add_argument("-e", "--engine", action="append", default=[], metavar="ENGINE[:METHOD]", help=ENGINE_HELP)
    lab.add_argument("--port", type=port, default=8080, metavar="N", help="another is taken where it is; default 8080")
    lab.add_argument("--no-open", dest="open", action="store_false", help="do not open the browser")
    lab.add_argument("--time-limit", type=seconds, default=60.0, metavar="S", help="for each flight [s]; default 60")

    report = command("report", "make one self-contained HTML page of it all")
    report.add_argument("scene", nargs="*", metavar="SCENE", help=SCENE_HELP + "; default: the whole catalogue")
    contest_options(report)
    report.add_argument(
        "--all", action="store_true", help="every method of every engine; default: each engine's defaults and best"
    )
    report.add_argument(
        "--from",
        dest="sources",
        action="append",
        default=[],
        metavar="DIR",
        help="tables that -o left, to draw without flying; given twice, the earlier first, also what changed",
    )
    report.add_argument(
        "-o", "--output", default="tumble-report.html", metavar="FILE.html", help="default: %(default)s"
    )
    columns = command("columns", "the tables there are, and what every column of each means, with its unit")
    columns.add_argument("table", nargs="?", metavar="TABLE", help="a table's file, with or without .csv")
    return top


def complete(top: Parser) -> None:
    """Answer a shell that asks for the words that fit, and end."""
    import argcomplete
    from argcomplete.completers import FilesCompleter

    from tumble.scenarios.read import catalogue

    for command in next(
        action for action in top._actions if isinstance(action, argparse._SubParsersAction)
    ).choices.values():
        for action in command._actions:
            if action.metavar in ("SCENE", "NAME"):
                action.completer = lambda prefix, **_: [*catalogue(), *FilesCompleter(["toml"])(prefix)]
    argcomplete.autocomplete(top)
