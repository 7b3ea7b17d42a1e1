"""What is written of the engines that took part."""

from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.worker import Failure
from tumble.compare.tables.shared import EngineRow, worded


def engine_row(running_engine: RunningEngine) -> EngineRow:
    """Return the row of one engine."""
    info = running_engine.info
    if isinstance(info, Failure):
        return EngineRow(running_engine.title, *worded(info.status), "", "", ", ".join(running_engine.methods), "", "")
    return EngineRow(
        running_engine.title,
        "ok",
        "",
        info.version,
        info.precision,
        ", ".join((*info.methods, *info.forced, *info.on_request)),
        ", ".join(sorted(info.features)),
        "; ".join(info.switched_off),
    )
