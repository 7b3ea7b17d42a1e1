"""The report: one self-contained page made from the tables and nothing else."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

from compare.tables.rows import RunRow
from reports import ablation, charts, families, hand_calculation, stability, standings, thrown_die, work_precision
from reports.hand_calculation import HAND
from reports.numerals import counted, figure, listed
from reports.rows import Tables, contestant, untuned

# One hue an engine, in the order they take part; the hand calculation is grey.
HUES = (218, 20, 130, 305, 75, 175, 345, 265)
HUE_SPREAD = 56.0


@dataclass(frozen=True)
class AuditNote:
    """What an audit found, and in which runs."""

    note: str
    runs: list[str]


def page(tables: Mapping[str, str]) -> str:
    """Return the report as HTML that needs no network.

    tables: file name -> CSV text, as compare.comparison.results.tables gives them.  Raises KeyError.
    """
    read = Tables(tables)
    contestants = [(run.engine, contestant(run)) for run in read.runs]
    colours = contestant_colours([*contestants, *((run.engine, untuned(run)) for run in read.sweep_runs)])
    scenes = [standings.section(read, scene, colours) for scene in read.scenes]
    costs = work_precision.sections(read, colours)
    drawn = {
        "error-over-time": any(scene.chart for scene in scenes),
        "error-against-run-time": any(cost.chart for cost in costs),
    }
    return (
        environment()
        .get_template("page.html")
        .render(
            verdicts=verdicts(read),
            hand_calculation=hand_calculation.section(read),
            thrown_die=thrown_die.section(read),
            families=families.families(read.agreements),
            agreement=families.verdicts(read.agreements),
            costs=costs,
            ablation=ablation.section(read),
            stability=stability.section(read),
            scenes=scenes,
            engines=read.engines,
            audit=audit_notes(read.runs),
            conditions=read.conditions,
            files=[name for name, text in tables.items() if len(text.splitlines()) > 1],
            specifications={kind: charts.SPECIFICATIONS[kind]() for kind, any_of_it in drawn.items() if any_of_it},
            library=charts.library() if any(drawn.values()) else None,
        )
    )


def environment() -> Environment:
    """Return the templates; what comes from the tables is data and is escaped."""
    found = Environment(
        loader=PackageLoader(__package__ or "reports"),
        autoescape=select_autoescape(("html",)),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    found.filters["figure"] = figure
    return found


def verdicts(tables: Tables) -> list[str]:
    """Return what the numbers say, one sentence each."""
    here = [engine.engine for engine in tables.engines if engine.status == "ok"]
    contestants = {contestant(run) for run in tables.runs if run.engine in here}
    said = [
        f"{counted(len(contestants), 'contestant')} of {counted(len(here), 'engine')} ({listed(here)}) flew "
        f"{counted(len(tables.scenes), 'scene')}; every vertex is held against a truth that no engine had a part in."
        if here
        else "No engine took part.",
        hand_calculation.verdict(hand_calculation.exact(tables)),
        *families.verdicts(tables.agreements)[:2],
        told_from_truth(tables.runs),
        furthest(tables.runs),
        not_plain(tables.runs),
    ]
    return [sentence for sentence in said if sentence]


def told_from_truth(runs: Sequence[RunRow]) -> str:
    """Return who was within the truth's limit wherever it flew, and in most scenes."""
    flown: dict[str, list[bool]] = {}
    for run in runs:
        if run.max_error_m is not None and run.engine != HAND:
            flown.setdefault(contestant(run), []).append(standings.within_limit(run))
    right = {name: len(own) for name, own in flown.items() if all(own)}
    if not flown:
        return ""
    if not right:
        return "No contestant came within the limit of the truth everywhere it flew."
    most = max(right.values())
    names = [name for name, count in right.items() if count == most]
    return f"{listed(names)} cannot be told from the truth in {counted(most, 'scene')}, all that were flown."


def furthest(runs: Sequence[RunRow]) -> str:
    """Return the largest error among the runs of engines that reported nothing wrong."""
    plain = [run for run in runs if run.status == "ok" and run.max_error_m is not None and run.engine != HAND]
    worst = max(plain, key=lambda run: run.max_error_m or 0.0, default=None)
    if worst is None or standings.within_limit(worst):
        return ""
    return (
        f"The largest error of a run that reported nothing wrong is {figure(worst.max_error_m or 0.0)} m: "
        f"{contestant(worst)} in {worst.scene}."
    )


def not_plain(runs: Sequence[RunRow]) -> str:
    """Return how many runs there were, and how many of them are not plain results."""
    kinds: dict[str, int] = {}
    for run in runs:
        if run.status != "ok":
            kind = standings.kind(run)
            kinds[kind] = kinds.get(kind, 0) + 1
    if not kinds:
        return f"All {counted(len(runs), 'run')} finished plainly." if runs else ""
    others = listed([f"{count} {kind}" for kind, count in kinds.items()])
    plain = len(runs) - sum(kinds.values())
    return f"Of {counted(len(runs), 'run')} {plain} finished plainly; {others}, each with its reason."


def audit_notes(runs: Sequence[RunRow]) -> list[AuditNote]:
    """Return what went wrong silently, each note once with the runs it is about."""
    found: dict[str, list[str]] = {}
    for run in runs:
        if standings.kind(run) == "flagged":
            why = run.status.partition(": ")[2]
            found.setdefault(why, []).append(f"{contestant(run)} in {run.scene}")
    return [AuditNote(note, own) for note, own in found.items()]


def contestant_colours(contestants: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Return one colour a contestant, the same in every scene: a hue an engine, varied over its methods.

    contestants: engine and contestant, in the order they take part, each as often as one likes.
    """
    methods: dict[str, list[str]] = {}
    for engine, name in dict.fromkeys(contestants):
        methods.setdefault(engine, []).append(name)
    hues = dict(zip((engine for engine in methods if engine != HAND), HUES * len(methods), strict=False))
    colours = {}
    for engine, names in methods.items():
        for place, name in enumerate(names):
            across = place / max(len(names) - 1, 1)
            lightness = 58 if place % 2 else 40
            if engine == HAND:
                colours[name] = f"hsl(0 0% {lightness:.0f}%)"
            else:
                colours[name] = f"hsl({(hues[engine] + HUE_SPREAD * (across - 0.5)) % 360:.0f} 70% {lightness:.0f}%)"
    return colours
