"""The findings of a comparison, from its tables."""

import math
from collections.abc import Collection, Iterable, Iterator, Sequence

from tumble.compare.engines import BY_HAND, OWN, SHIPPED
from tumble.compare.judge.agreement import AgreementRow
from tumble.compare.tables.shared import FindingRow, RunRow

# Statuses of contestants that did not start.
UNSUPPORTED = ("skipped", "missing")


def error_findings(
    runs: Iterable[RunRow], defaults: Collection[str] = (), named: Collection[str] = ()
) -> Iterator[FindingRow]:
    """Yield, for each scene, the most and the least accurate contestant, the errors of engines, and failures.

    Parameters
    ----------
    runs : rows of runs.csv
    defaults : ENGINE:METHOD of contestants that are their engine's default, as far as known
    named : ENGINE:METHOD of contestants that the user named

    Returns
    -------
    rows of findings.csv
    """
    scenes: dict[str, list[RunRow]] = {}
    for run in runs:
        scenes.setdefault(run.scene, []).append(run)
    for own in scenes.values():
        yield from scene_findings(own, defaults, named)


def scene_findings(
    runs: Sequence[RunRow], defaults: Collection[str] = (), named: Collection[str] = ()
) -> Iterator[FindingRow]:
    """Yield the findings of one scene.

    Parameters
    ----------
    runs : rows of runs.csv, of one scene
    defaults, named : as of `error_findings`

    Returns
    -------
    rows of findings.csv
    """
    finished = ranked(runs)
    engines: dict[str, list[RunRow]] = {}
    for run in runs:
        engines.setdefault(run.engine, []).append(run)
    first = ranked(own[0] for engine, own in engines.items() if engine != OWN)
    others = [run for run in finished if run.engine not in (OWN, BY_HAND)]
    for finding, found in (
        ("most accurate", plainest(finished)),
        ("most accurate engine", plainest(others)),
        ("first method", first),
        ("engine default", [run for own in engines.values() for run in as_shipped(own, defaults)]),
        ("named method", [run for run in finished if f"{run.engine}:{run.method}" in named]),
        ("least accurate", finished[-1:]),
    ):
        yield from (error_finding(finding, run) for run in found)
    unsupported = sum(run.status in UNSUPPORTED for run in runs)
    for finding, count in (("unfinished", len(runs) - len(finished) - unsupported), ("unsupported", unsupported)):
        if count:
            yield FindingRow(finding=finding, scene=runs[0].scene, value=count, unit="1")


def ranked(runs: Iterable[RunRow]) -> list[RunRow]:
    """Return the runs that finished, the most accurate first."""
    return sorted((run for run in runs if math.isfinite(error_m(run))), key=error_m)


def plainest(ranked: Sequence[RunRow]) -> list[RunRow]:
    """Return the most accurate run with status ok, or else the most accurate one."""
    return [run for run in ranked if run.status == "ok"][:1] or list(ranked[:1])


def error_m(run: RunRow) -> float:
    """Return the largest error of a run.

    Parameters
    ----------
    run : a row of runs.csv

    Returns
    -------
    the error [m], at least the resolution of the reference; infinite if there is none
    """
    return math.inf if run.max_error_m is None else max(run.max_error_m, run.resolution_m or 0.0)


def as_shipped(runs: Sequence[RunRow], defaults: Collection[str]) -> list[RunRow]:
    """Return the run with the engine's defaults, METHOD+defaults before METHOD, or none."""
    own = [run for run in runs if f"{run.engine}:{run.method}" in defaults]
    return sorted(own, key=lambda run: not run.method.endswith(SHIPPED))[:1]


def error_finding(finding: str, run: RunRow) -> FindingRow:
    """Return a finding whose value is the error of a run."""
    return FindingRow(
        finding=finding,
        scene=run.scene,
        engine=run.engine,
        method=run.method,
        value=run.max_error_m,
        unit="m",
        resolution=run.resolution_m,
    )


def agreement_findings(pairs: Iterable[AgreementRow]) -> Iterator[FindingRow]:
    """Yield, for each scene, the two engines whose agreement is most misleading: their distance and error."""
    scenes: dict[str, list[AgreementRow]] = {}
    for pair in pairs:
        if pair.engine_a != pair.engine_b:
            scenes.setdefault(pair.scene, []).append(pair)
    for scene, own in scenes.items():
        best = min(own, key=lambda pair: pair.apart_m / min(pair.error_a_m, pair.error_b_m))
        for finding, value in (
            ("agreement distance", best.apart_m),
            ("agreement error", max(best.error_a_m, best.error_b_m)),
        ):
            yield FindingRow(
                finding=finding,
                scene=scene,
                engine=best.engine_a,
                method=best.method_a,
                other=best.contestant_b,
                value=value,
                unit="m",
            )
