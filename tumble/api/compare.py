"""`tumble.compare`: every contestant on every scene, compared with the reference solution."""

from tumble.api.contestants import Contestants, contestant_list
from tumble.api.limits import limits, step
from tumble.api.progress import in_notebook
from tumble.api.result import Result, call, text_of
from tumble.api.scene import Scenes, in_parts, named_scenes
from tumble.api.session import kept_ready
from tumble.compare.comparison.results import comparison_tables
from tumble.compare.comparison.study import compare_scenes
from tumble.compare.comparison.worst import worst_scenes
from tumble.compare.contact.results import contact_tables
from tumble.compare.contact.rows import contact_rows
from tumble.compare.contact.study import contact_scenes
from tumble.compare.coursework.results import coursework_tables
from tumble.compare.motion.study import film_scenes
from tumble.compare.run.running_engines import TIME_LIMIT_S
from tumble.compare.run.worker import MEMORY_LIMIT
from tumble.compare.tables.frames import merged
from tumble.reports.comparison_text import comparison_text
from tumble.reports.contact_text import contact_text


def compare(
    scenes: Scenes,
    contestants: Contestants = (),
    *,
    dt: float | None = None,
    film: bool | None = None,
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    progress: bool = True,
) -> Result:
    """Run every scene with every contestant, and compare the vertices with the reference solution.

    Parameters
    ----------
    scenes : one or several: a name, a path, a table as in TOML, or a `Scene`.
    contestants : one or several: ENGINE[@RELEASE][:METHOD], FILE[:METHOD], or a function as `tumble.engine` takes it.
        Empty: every installed engine.
    dt : step [s]; None: each scene's own.
    film : also sample the motion finely, so that the page shows it; None: in a notebook.
    time_limit : of each run [s].
    memory_limit : of each engine's process [B].
    progress : draw a bar in a terminal or a notebook.

    Returns
    -------
    Result
        Tables `runs`, `vertex_errors`, `error_over_time`, `agreement`, `scenes`, `engines`, `findings`, `conditions`;
        of scenes with a plane also `contact` and `contact_scans`, of scenes with a sensor `sensors` and
        `sensor_errors`.

    Raises
    ------
    UserError
        For a scene, an engine, a method or a step that cannot be used.

    Examples
    --------
    >>> import tumble
    >>> result = tumble.compare("two-hits", ["tumble:rk4", "tumble:exact"])
    >>> result.runs.sort_values("max_error_m").method.iloc[0]
    'exact'
    """
    named, engines = named_scenes(scenes), contestant_list(contestants)
    asked = [in_parts(one) for one in named]
    dt, limit = step(dt), limits(time_limit, memory_limit, progress)
    with kept_ready():
        found = compare_scenes(asked, engines, dt=dt, **limit)
        contacts = contact_scenes(found.comparisons, engines, dt=dt, **limit)
        alone = [one.scene for one in found.comparisons]
        watched = film_scenes(alone, engines, dt=dt, **limit) if (in_notebook() if film is None else film) else {}
    own = comparison_tables(found.comparisons, found.engines, call("compare", scenes, contestants, dt=dt))
    text = text_of(
        piece
        for one in found.comparisons
        for pieces in (
            contact_text([row for each in contacts if each.scene is one.scene for row in contact_rows(each)]),
            comparison_text(one, None),
        )
        for piece in pieces
    )
    documents = {
        name: words
        for scene, one in zip(named, found.comparisons, strict=True)
        for name, words in worst_scenes(one, scene.to_dict(), scene.folder).items()
    }
    tables = merged(own, coursework_tables(found.comparisons), contact_tables(contacts), watched)
    return Result(tables, text, documents=documents)
