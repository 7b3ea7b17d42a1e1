"""The study of `tumble releases`: an engine and scenes in, a ledger of its releases and their changes out."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from tumble.compare.releases.changes import changes
from tumble.compare.releases.ledger import Ledger, ledger
from tumble.compare.releases.notes import shipped_notes
from tumble.compare.releases.schemas import ReleaseChangeRow
from tumble.compare.run.engines import environments, installing, registry
from tumble.compare.run.engines.registry import BadEngine
from tumble.compare.run.execution import resumable
from tumble.compare.run.pool import POOL
from tumble.compare.run.progress import Display, no_display
from tumble.compare.run.running_engines import TIME_LIMIT_S, flights
from tumble.compare.run.starting import started
from tumble.compare.run.worker import MEMORY_LIMIT
from tumble.compare.tables.engines import engine_row
from tumble.compare.tables.shared import EngineRow
from tumble.scenarios.scene import Scene

log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Releases:
    """The result of `tumble releases`.

    Parameters
    ----------
    ledger : the runs of the releases, the oldest release first
    changes : what changed at each release
    engines : the releases as engines
    """

    ledger: Ledger
    changes: tuple[ReleaseChangeRow, ...]
    engines: tuple[EngineRow, ...]


def compare_releases(
    engine: str,
    scenes: Sequence[Scene],
    *,
    first: str | None = None,
    last: str | None = None,
    install: bool = False,
    folder: Path | None = None,
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    display: Display = no_display,
    finished: Callable[[Releases], object] = lambda found: None,
) -> Releases:
    """Run the same scenes with every release of an engine, and find what changed at each.

    Parameters
    ----------
    engine : name of the engine, without release and method
    scenes : the scenes; run times are measured on the first
    first, last : leave out older and newer releases
    install : first install the releases that the package index has, each into its own environment
    folder : where finished runs are saved; a later call continues from there
    time_limit : for each run [s]
    memory_limit : for each engine's process [B]
    display : shows progress
    finished : called with the result before the saved runs are removed

    Returns
    -------
    the ledger and the changes

    Raises
    ------
    BadEngine : the engine has no such release, or fewer than two
    """
    contestants = [f"{engine}@{release}" for release in releases(engine, first, last, install, display)]
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
    with started(contestants, time_limit, memory_limit, display) as running_engines, resumable(folder):
        landing = [scene for scene in scenes if scene.plane]
        with display(flights(running_engines, [*scenes, *landing]) + len(scenes) + 1) as on_progress:
            found = ledger(running_engines, scenes, on_progress)
        changed = tuple(changes(found, shipped_notes(engine)))
        result = Releases(found, changed, tuple(map(engine_row, running_engines)))
        finished(result)
    return result


def releases(engine: str, first: str | None, last: str | None, install: bool, display: Display) -> list[str]:
    """Return the releases from first to last, the oldest first, installed if asked.  Raises BadEngine."""
    if engine in registry.names() and not registry.package(engine).pins:
        raise BadEngine(f"{engine} has no releases of its own")
    known = POOL.get().releases(engine)
    known = known or (environments.releases_on_index(engine) if install else environments.releases_here(engine))
    for release in (first, last):
        if release and release not in known and (install or not environments.in_order([release])):
            raise BadEngine(f"{engine} has no release {release}; choose one of {', '.join(known)}")
    least, most = (environments.numbers_of(end) if end else None for end in (first, last))
    found = [
        release
        for release in known
        if (least is None or environments.numbers_of(release) >= least)
        and (most is None or environments.numbers_of(release) <= most)
    ]
    if len(found) < 2:
        here = ", ".join(environments.releases_here(engine)) or "none"
        raise BadEngine(
            f"{engine}: at least two releases are needed; installed: {here}; --install installs those of the "
            "package index"
        )
    if install:
        missing = [name for release in found if environments.located(name := f"{engine}@{release}")[1] is None]
        log.info(f"environments to make: {', '.join(missing) or 'none'}")
        with display(len(missing), "installing") as on_progress:
            for failed in installing.install_all(missing, on_progress):
                raise failed
    return found
