"""What is written of the engines that took part."""

from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.status import Failure
from tumble.compare.tables.shared import EngineRow


def engine_row(running_engine: RunningEngine) -> EngineRow:
    """Return the row of one engine.

    Parameters
    ----------
    running_engine : the engine

    Returns
    -------
    its row of engines.csv
    """
    info = running_engine.info
    if isinstance(info, Failure):
        methods = ", ".join(running_engine.methods)
        return EngineRow(engine=running_engine.title, status=info.status.value, why=info.reason, methods=methods)
    return EngineRow(
        engine=running_engine.title,
        status="ok",
        version=info.version,
        precision=info.precision,
        methods=", ".join(info.every_method),
        features=", ".join(sorted(info.features)),
        switched_off="; ".join(info.switched_off),
    )
