"""`tumble.releases`: what changed between an engine's releases."""

from tumble.api.limits import limits
from tumble.api.result import Result, call, text_of
from tumble.api.scene import Scenes, questions
from tumble.compare.releases.ledger import SCENES
from tumble.compare.releases.results import ledger_tables
from tumble.compare.releases.study import compare_releases
from tumble.compare.run.running_engines import TIME_LIMIT_S
from tumble.compare.run.worker import MEMORY_LIMIT
from tumble.reports.releases import ledger_markdown, ledger_text


def releases(
    engine: str,
    scenes: Scenes = SCENES,
    *,
    first: str | None = None,
    last: str | None = None,
    install: bool = False,
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    progress: bool = True,
) -> Result:
    """Run the same scenes with every release of an engine, and find what changed at each.

    Parameters
    ----------
    engine : its name, without release and method.
    scenes : one or several: a name, a path, a table as in TOML, or a `Scene`.
    first, last : leave out older and newer releases.
    install : first install the releases that the package index has, each into its own environment.
    time_limit : of each run [s].
    memory_limit : of each engine's process [B].
    progress : draw a bar in a terminal or a notebook.

    Returns
    -------
    Result
        Tables `releases`, `release_changes`, `engines`, `conditions`.

    Raises
    ------
    UserError
        For an engine that has fewer than two releases here.

    Examples
    --------
    >>> import tumble
    >>> tumble.releases("handcalc")
    Traceback (most recent call last):
        ...
    tumble.compare.run.contestant.BadEngine: handcalc has no releases of its own
    >>> print(tumble.releases("mujoco", first="3.10.0", install=True).answer)  # doctest: +SKIP
    mujoco, 2 releases from 3.10.0 to 4.0.0: 4.0.0 behaves differently from the previous release.
    """
    found = compare_releases(
        engine,
        questions(scenes),
        first=first,
        last=last,
        install=install,
        **limits(time_limit, memory_limit, progress),
    )
    command = call("releases", engine, scenes)
    return Result(
        ledger_tables(found.ledger, found.changes, found.engines, command),
        text_of(ledger_text(found.ledger, found.changes)),
        documents={"releases.md": ledger_markdown(found.ledger, found.changes, command)},
    )
