"""The parser of the command line: every command and its options, and the nearest word to a wrong one."""

import argparse
import math
import os
import re
import sys
import textwrap
from typing import NoReturn

from tumble.examples import epilog
from tumble.starters import STARTERS

EXIT_USER = 2  # the user's mistake
AT_ONCE = ("scenes", "columns")  # commands without progress
PAGE = "tumble-report.html"  # what `tumble report` writes
SHELLS = ("bash", "zsh", "fish")
SCENE_HELP = "a scene of the catalogue (see `tumble scenes`) or the path of a scene file (TOML)"
ENGINE_HELP = (
    "engine and method to run: ENGINE[@RELEASE][:METHOD] (see `tumble engines`) or an engine file of your own, "
    "./mine.py[:METHOD] or ./mine.toml[:METHOD]; repeat for several"
)
TABLES_HELP = "also write the tables as CSV files into folder DIR"


# A number with an optional unit; without one it is in metres.
LENGTH = re.compile(r"(.*?[\d.])\s*([a-zµμ]*)", re.IGNORECASE)
METRES = {
    "": 1.0, "m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9, "pm": 1e-12,
    "km": 1e3, "in": 0.0254, "ft": 0.3048,
}  # fmt: skip


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors are one line."""

    def _check_value(self, action: argparse.Action, value: object) -> None:
        """Refuse an unknown word and suggest the nearest."""
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
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive number of {unit}")
    return value


def instant(text: str) -> float:
    """Return a time [s] of either sign."""
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
        raise argparse.ArgumentTypeError(f"{text!r} is not a port number, 0 to 65535")
    return int(text)


def shard(text: str) -> tuple[int, int]:
    """Return number and count of a shard."""
    number, _, count = text.partition("/")
    if not (number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count) < 10**6):
        raise argparse.ArgumentTypeError(f"{text!r} is not a part of a whole, such as 1/4, 2/4, 3/4 or 4/4")
    return int(number), int(count)


def workers(text: str) -> int:
    """Return a number of workers."""
    if not (text.isdecimal() and 1 <= int(text) <= 1000):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of workers, 1 to 1000")
    return int(text)


def metres(text: str) -> float:
    """Return a positive number of metres, from a length with its unit or a bare number of metres.

    Parameters
    ----------
    text : such as 0.001, 1mm or 50um

    Returns
    -------
    float [m]

    Raises
    ------
    argparse.ArgumentTypeError : the text is no such length
    """
    match = LENGTH.fullmatch(text.strip())
    unit = match[2] if match else ""
    if match is None or unit not in METRES:
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive length, such as 0.001, 1mm or 50um")
    try:
        value = float(match[1]) * METRES[unit]
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive length, such as 0.001, 1mm or 50um")
    return value


def parser() -> Parser:
    """Return the parser of all commands."""
    top = Parser(
        prog="tumble",
        description="Run the same throw of a rigid body in several physics engines, compare each with an exact "
        "reference solution, and find which one is wrong, by how much, and why.",
    )
    top.add_argument("--version", action="store_true", help="print the version and exit")
    top.add_argument("--completion", choices=SHELLS, help="print the completion script for this shell and exit")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", parser_class=Parser)

    def command(name: str, what: str) -> argparse.ArgumentParser:
        made = commands.add_parser(
            name,
            help=what,
            description=textwrap.fill(f"{what[0].upper()}{what[1:]}.", 80),
            epilog=epilog(name),
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        if name not in AT_ONCE:
            made.add_argument("-q", "--quiet", action="store_true", help="show no progress on standard error")
        return made

    def engine_option(to: argparse.ArgumentParser, default: str = "the engines installed with Tumble") -> None:
        meaning = f"{ENGINE_HELP}; default: {default}"
        to.add_argument("-e", "--engine", action="append", default=[], metavar="ENGINE[:METHOD]", help=meaning)

    def time_option(to: argparse.ArgumentParser, what: str = "each run", default: float = 60.0) -> None:
        meaning = f"time limit for {what} [s] (default: {default:g})"
        to.add_argument("--time-limit", type=seconds, default=default, metavar="S", help=meaning)

    def limit_options(to: argparse.ArgumentParser, default: float = 60.0) -> None:
        time_option(to, default=default)
        meaning = "memory limit for each engine process [GiB] (default: 4)"
        to.add_argument("--memory-limit", type=gibibytes, default=4 << 30, metavar="GIB", help=meaning)

    def step_option(to: argparse.ArgumentParser) -> None:
        to.add_argument("--dt", type=seconds, metavar="S", help="time step [s] (default: the scene's own)")

    def figure_options(to: argparse.ArgumentParser) -> None:
        to.add_argument("--svg", metavar="FILE", help="also save the figure as SVG; needs `pip install '.[figures]'`")
        to.add_argument("--png", metavar="FILE", help="also save the figure as PNG; needs `pip install '.[figures]'`")

    def share_options(to: argparse.ArgumentParser) -> None:
        to.add_argument(
            "--shard",
            type=shard,
            metavar="I/N",
            help="run only part I of N, and leave its results in folder -o (default: shard-I-of-N) for `tumble merge`",
        )
        to.add_argument(
            "--cache",
            metavar="DIR",
            help="folder where finished runs are saved, and found again by any command on machines of one kind",
        )

        to.add_argument(
            "--workers", type=workers, metavar="N", help="run on N Dask workers of this machine; needs the extra dask"
        )
        to.add_argument(
            "--scheduler",
            default=os.environ.get("TUMBLE_SCHEDULER"),
            metavar="ADDRESS",
            help="run on the workers of this Dask scheduler: HOST:PORT or tls://HOST:PORT (default: TUMBLE_SCHEDULER)",
        )
        for name, what in (("ca", "certificate authority"), ("cert", "certificate"), ("key", "private key")):
            meaning = f"with --scheduler tls://HOST:PORT: file of the {what} (PEM)"
            to.add_argument(f"--tls-{name}", metavar="FILE", help=meaning)
        to.add_argument(
            "--insecure-scheduler",
            action="store_true",
            help="allow a scheduler on another machine without TLS: whoever reaches its port can run code here",
        )

    def parquet_option(to: argparse.ArgumentParser) -> None:
        meaning = "with -o: also write the tables as Parquet; needs `pip install pyarrow`"
        to.add_argument("--parquet", action="store_true", help=meaning)

    scenes = command("scenes", "list the scenes of the catalogue and what each needs, or print one as TOML")
    scenes.add_argument(
        "scene",
        nargs="?",
        metavar="NAME",
        help="scene to print as TOML, to copy and change; for the path of your own scene file also its mass, volume, "
        "centre of mass and moments of inertia",
    )
    engines = command("engines", "list the engines: version, methods, precision, and why one is missing")
    engines.add_argument(
        "-e",
        "--engine",
        action="append",
        default=[],
        metavar="ENGINE",
        help="engine to list: ENGINE[@RELEASE] or an engine file of your own; repeat for several; default: all",
    )
    engines.add_argument(
        "--install",
        nargs="+",
        default=[],
        metavar="ENGINE[@RELEASE]",
        help="install each engine into its own environment (downloads packages)",
    )
    engines.add_argument(
        "--remove", nargs="+", default=[], metavar="ENGINE[@RELEASE]", help="remove these engine environments"
    )
    engines.add_argument(
        "--check", nargs="+", metavar="ENGINE", help="check that these engines satisfy the engine contract"
    )
    time_option(engines, "each check of --check")
    engines.add_argument(
        "--template",
        choices=(*STARTERS,),
        metavar="LANGUAGE",
        help="write an example engine into the current folder; LANGUAGE: cpp, js, rust, csharp or python",
    )

    run = command("run", "run one scene in one engine and write the trajectory as CSV")
    run.add_argument("scene", metavar="SCENE", help=SCENE_HELP)
    engine_option(run, "tumble; in a scene with a plane tumble:events")
    step_option(run)
    limit_options(run)
    run.add_argument("-o", "--output", metavar="FILE", help="CSV file to write (default: standard output)")
    run.add_argument(
        "--sensors",
        metavar="DIR",
        help="folder for sensors.csv and sensor-errors.csv: readings of the scene's sensors, true readings and errors",
    )

    compare = command("compare", "compare every engine with the reference solution: ranking and error tables")
    compare.add_argument("scene", nargs="+", metavar="SCENE", help=SCENE_HELP)
    engine_option(compare)
    step_option(compare)
    limit_options(compare)
    compare.add_argument(
        "--all", action="store_true", help="print the error table of every method (default: each engine's first)"
    )
    compare.add_argument(
        "--vertex", type=int, metavar="K", help="vertex in the error tables (default: the one with the largest error)"
    )
    compare.add_argument("-o", "--output", metavar="DIR", help=f"{TABLES_HELP}, with every vertex")
    parquet_option(compare)
    figure_options(compare)
    share_options(compare)

    sweep = command("sweep", "measure error against run time over a sequence of time steps or tolerances")
    sweep.add_argument("scene", nargs="*", metavar="SCENE", help=SCENE_HELP + "; default: yardstick")
    engine_option(sweep)
    sweep.add_argument(
        "--reference",
        default="tumble:rk4",
        metavar="ENGINE:METHOD",
        help="contestant that run times are divided by (default: %(default)s)",
    )
    sweep.add_argument(
        "--observable",
        metavar="NAME",
        help="observable of contact.csv whose error is measured above a plane, of a vector without its component; "
        "default: the scene's main one, such as the distance until it stops",
    )
    limit_options(sweep)
    sweep.add_argument("-o", "--output", metavar="DIR", help=TABLES_HELP)
    parquet_option(sweep)
    figure_options(sweep)
    share_options(sweep)

    advise = command("advise", "find the fastest engine, method and time step within a given error")
    advise.add_argument("scene", nargs="+", metavar="SCENE", help=SCENE_HELP)
    advise.add_argument(
        "--tolerance",
        type=metres,
        required=True,
        metavar="M",
        help="largest acceptable vertex error: a length such as 1mm, or a number in metres",
    )
    advise.add_argument(
        "--beyond-samples",
        action="store_true",
        help="also try fixed time steps longer than the sampling interval, with errors measured where they end; "
        "adaptive methods stop at every sample all the same",
    )
    engine_option(advise)
    limit_options(advise)

    stability = command("stability", "stability maps, the largest stable step of each method, and extreme cases")
    extreme = (
        ", one with a plane (mapped over friction and angle), or an extreme case (spin-1e4, far-1e7, denormal ...)"
    )
    default = "; default: the stiff scenes and all extreme cases"
    stability.add_argument("scene", nargs="*", metavar="SCENE", help=SCENE_HELP + extreme + default)
    engine_option(stability)
    limit_options(stability, 20.0)
    stability.add_argument(
        "-o", "--output", metavar="DIR", help=f"{TABLES_HELP}; the same command continues an interrupted run there"
    )
    parquet_option(stability)
    figure_options(stability)
    share_options(stability)

    grade = command("grade", "find the error of a trajectory that another program wrote, and its most likely cause")
    grade.add_argument(
        "file",
        metavar="FILE",
        help="trajectory with one row a time: CSV, JSON lines or Parquet; - is standard input",
    )
    grade.add_argument("--scene", required=True, metavar="SCENE", help=f"the scene of the trajectory: {SCENE_HELP}")
    grade.add_argument(
        "--map",
        action="append",
        default=[],
        metavar="COLUMN=NAME",
        help="name of a column, with its unit: t_s, t_ms, x_cm, qw, r11, vx_m_s, wx_deg_s, v0x_m, ax_g, gx_rad_s, ..., "
        "or ignore",
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
    grade.add_argument(
        "--sensor", metavar="NAME", help="sensor of the scene that readings are of (default: the scene's only one)"
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
        "--spin",
        choices=("world", "body"),
        default="world",
        help="axes of the angular velocity in the file (default: %(default)s)",
    )
    grade.add_argument("--decimal", choices=(".", ","), default=".", help="decimal sign of the file (default: a point)")
    grade.add_argument(
        "--tolerance", type=metres, metavar="M", help="exit 1 if a vertex error is larger: 1mm, or 0.001 for metres"
    )
    grade.add_argument(
        "--search",
        type=seconds,
        metavar="S",
        help="processor time after which the search stops with the best cause so far [s] (default: 2, or less on a "
        "slow machine, so that an answer takes about 3)",
    )
    grade.add_argument("--json", action="store_true", help="print the grade as JSON")
    grade.add_argument("-o", "--output", metavar="DIR", help=TABLES_HELP)
    parquet_option(grade)

    check = command("check", "compare errors, orders, energy and run times with a baseline; exit 1 if any is worse")
    check.add_argument("scene", nargs="*", metavar="SCENE", help=SCENE_HELP + "; default: the baseline's, or all")
    engine_option(check, "those of the baseline, or the engines installed with Tumble")
    check.add_argument(
        "--accept", action="store_true", help="write the new record as the baseline; exit code 1 if that changes one"
    )
    check.add_argument(
        "--accept-failures",
        action="store_true",
        help="with --accept: record contestants that crashed, timed out or are missing, too",
    )
    check.add_argument("--baseline", metavar="DIR", help="folder of the record to compare with")
    check.add_argument("--trust", action="store_true", help="run the engine files that the baseline names")
    check.add_argument(
        "--candidate", metavar="DIR", help="folder of a record to compare with the baseline, instead of running"
    )
    check.add_argument(
        "-o", "--output", metavar="DIR", help="write the new record, summary.md and junit.xml into folder DIR"
    )
    parquet_option(check)
    check.add_argument(
        "--tolerances", metavar="FILE.toml", help="how much each column may change (default: see docs/check.md)"
    )
    check.add_argument(
        "--no-times",
        action="store_true",
        help="do not record run times (use this when baseline and check run on different machines)",
    )
    limit_options(check)
    share_options(check)

    ablate = command("ablate", "measure the time saved by switching off features a scene does not need")
    ablate.add_argument("scene", nargs="*", metavar="SCENE", help=SCENE_HELP + "; default: three that need little")
    engine_option(ablate)
    limit_options(ablate)
    ablate.add_argument("-o", "--output", metavar="DIR", help=TABLES_HELP)
    parquet_option(ablate)

    releases = command("releases", "find what changed between the releases of an engine, from the numbers")
    releases.add_argument("engine", metavar="ENGINE", help="an engine that has releases (see `tumble engines`)")
    releases.add_argument(
        "scene", nargs="*", metavar="SCENE", help=SCENE_HELP + "; default: three that show most differences"
    )
    releases.add_argument("--from", dest="first", metavar="RELEASE", help="leave out the releases before this one")
    releases.add_argument("--to", dest="last", metavar="RELEASE", help="leave out the releases after this one")
    releases.add_argument(
        "--install",
        action="store_true",
        help="first install every release of the package index, each into its own environment",
    )
    limit_options(releases)
    releases.add_argument(
        "-o",
        "--output",
        metavar="DIR",
        help="write CSV tables and releases.md into folder DIR; the same command continues an interrupted run there",
    )
    parquet_option(releases)
    share_options(releases)

    lab = command("lab", "throw the die in a browser and watch every engine beside the reference solution")
    lab.add_argument("scene", nargs="?", default="die-ray", metavar="SCENE", help=SCENE_HELP + "; default: %(default)s")
    engine_option(lab, "tumble, pybullet, mujoco:euler and mujoco:rk4")
    lab.add_argument(
        "--port", type=port, default=8080, metavar="N", help="port (default: %(default)s; the next free one if in use)"
    )
    lab.add_argument("--no-open", dest="open", action="store_false", help="do not open a browser")
    time_option(lab)

    report = command("report", "write one self-contained HTML page with all results")
    report.add_argument("scene", nargs="*", metavar="SCENE", help=SCENE_HELP + "; default: the whole catalogue")
    engine_option(report)
    step_option(report)
    limit_options(report)
    report.add_argument(
        "--all",
        action="store_true",
        help="run every method of every engine (default: each engine's default and best methods)",
    )
    report.add_argument(
        "--from",
        dest="sources",
        action="append",
        default=[],
        metavar="DIR",
        help="build the page from saved tables instead of running; give it twice (old, new) to add a section on "
        "changes",
    )
    report.add_argument(
        "-o", "--output", default=PAGE, metavar="FILE.html", help="page to write (default: %(default)s)"
    )
    share_options(report)
    merge = command("merge", "merge the results of all shards (--shard) of a command into those of the whole")
    merge.add_argument("folder", nargs="+", metavar="DIR", help="folder that a shard left; in any order")
    merge.add_argument(
        "-o", "--output", metavar="DIR", help="what -o is to the command itself: a folder for its tables, or a page"
    )
    columns = command("columns", "list all tables, or the columns of one with units and meanings")
    columns.add_argument("table", nargs="?", metavar="TABLE", help="name of a table file, with or without .csv")
    return top


def complete(top: Parser) -> None:
    """Print the completions that a shell asks for, and exit."""
    import argcomplete
    from argcomplete.completers import FilesCompleter

    from tumble.scenarios.read import catalogue, contact_catalogue

    names = [*catalogue(), *contact_catalogue()]
    for command in next(
        action for action in top._actions if isinstance(action, argparse._SubParsersAction)
    ).choices.values():
        for action in command._actions:
            if action.metavar in ("SCENE", "NAME"):
                action.completer = lambda prefix, **_: [*names, *FilesCompleter(["toml"])(prefix)]
    argcomplete.autocomplete(top)
