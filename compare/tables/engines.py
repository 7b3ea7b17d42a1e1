"""What is written of the engines that took part."""

from tumble.compare.run.participants import Participant
from tumble.compare.run.worker import Failure
from tumble.compare.tables.shared import EngineRow, worded


def engine_row(participant: Participant) -> EngineRow:
    """Return the row of one engine."""
    info = participant.info
    if isinstance(info, Failure):
        return EngineRow(participant.title, *worded(info.status), "", "", ", ".join(participant.methods), "", "")
    return EngineRow(
        participant.title,
        "ok",
        "",
        info.version,
        info.precision,
        ", ".join((*info.methods, *info.forced, *info.on_request)),
        ", ".join(sorted(info.features)),
        "; ".join(info.switched_off),
    )
