"""What a comparison found: the numbers of its sentences, read off its tables."""

import math
from collections.abc import Collection, Iterable, Iterator, Sequence

from tumble.compare.engines import BY_HAND, OWN, SHIPPED
from tumble.compare.judge.agreement import AgreementRow
from tumble.compare.tables.shared import FindingRow, RunRow

# Of who never began.
UNABLE = ("skipped", "missing")


def error_findings(
    runs: Iterable[RunRow], defaults: Collection[str] = (), asked: Collection[str] = ()
) -> Iterator[FindingRow]:
    """Yield, scene by scene, who is nearest and furthest, the engines as asked for and as shipped, and who got lost.

    defaults: ENGINE:METHOD of those that do what their engines do where nobody sets anything, as far as known; asked:
    of those that take part because somebody named them.
    """
    scenes: dict[str, list[RunRow]] = {}
    for run in runs:
        scenes.setdefault(run.scene, []).append(run)
    for own in scenes.values():
        yield from scene_findings(own, defaults, asked)


def scene_findings(
    runs: Sequence[RunRow], defaults: Collection[str] = (), asked: Collection[str] = ()
) -> Iterator[FindingRow]:
    """Yield what was found in one scene; defaults, asked: as of `error_findings`."""
    flown = ranked(runs)
    engines: dict[str, list[RunRow]] = {}
    for run in runs:
        engines.setdefault(run.engine, []).append(run)
    first = ranked(own[0] for engine, own in engines.items() if engine != OWN)
    others = [run for run in flown if run.engine not in (OWN, BY_HAND)]
    for finding, found in (
        ("nearest", plainest(flown)),
        ("nearest engine", plainest(others)),
        ("asked for", first),
        ("as shipped", [run for own in engines.values() for run in as_shipped(own, defaults)]),
        ("as asked", [run for run in flown if f"{run.engine}:{run.method}" in asked]),
        ("furthest", flown[-1:]),
    ):
        yield from (error_finding(finding, run) for run in found)
    unable = sum(run.status in UNABLE for run in runs)
    for finding, count in (("unfinished", len(runs) - len(flown) - unable), ("unable", unable)):
        if count:
            yield FindingRow(finding, runs[0].scene, "", "", "", count, "1")


def ranked(runs: Iterable[RunRow]) -> list[RunRow]:
    """Return the runs that flew to their end, the nearest to the truth first."""
    return sorted((run for run in runs if math.isfinite(error_m(run))), key=error_m)


def plainest(ranked: Sequence[RunRow]) -> list[RunRow]:
    """Return the nearest run: what was clamped or looked up is nobody to be near by, unless there is no other."""
    return [run for run in ranked if run.status == "ok"][:1] or list(ranked[:1])


def error_m(run: RunRow) -> float:
    """Return the largest error, not below what the truth can tell [m]; infinite where there is none."""
    return math.inf if run.max_error_m is None else max(run.max_error_m, run.resolution_m or 0.0)


def as_shipped(runs: Sequence[RunRow], defaults: Collection[str]) -> list[RunRow]:
    """Return the run of a user who sets nothing, METHOD+defaults before METHOD, or none."""
    own = [run for run in runs if f"{run.engine}:{run.method}" in defaults]
    return sorted(own, key=lambda run: not run.method.endswith(SHIPPED))[:1]


def error_finding(finding: str, run: RunRow) -> FindingRow:
    """Return a finding that is the error of a run."""
    return FindingRow(finding, run.scene, run.engine, run.method, "", run.max_error_m, "m", run.resolution_m)


def agreement_findings(pairs: Iterable[AgreementRow]) -> Iterator[FindingRow]:
    """Yield, for each scene, the two engines whose agreement misleads most: how far apart, and how far off."""
    scenes: dict[str, list[AgreementRow]] = {}
    for pair in pairs:
        if pair.engine_a != pair.engine_b:
            scenes.setdefault(pair.scene, []).append(pair)
    for scene, own in scenes.items():
        best = min(own, key=lambda pair: pair.apart_m / min(pair.error_a_m, pair.error_b_m))
        key = scene, best.engine_a, best.method_a, best.contestant_b
        yield FindingRow("apart", *key, best.apart_m, "m")
        yield FindingRow("both off", *key, max(best.error_a_m, best.error_b_m), "m")
