"""All tables of a ledger, by file name."""

from collections.abc import Sequence

import pandas as pd

from compare.releases.ledger import Ledger
from compare.releases.schemas import CHANGES, RELEASES, ReleaseChangeRow
from compare.run.participants import Participant
from compare.run.provenance import conditions
from compare.tables.engines import engine_row
from compare.tables.frames import frame
from compare.tables.shared import CONDITIONS, ENGINES


def ledger_tables(
    ledger: Ledger, changes: Sequence[ReleaseChangeRow], participants: Sequence[Participant], command: str
) -> dict[str, pd.DataFrame]:
    """Return every table by file name; command reruns them."""
    return {
        RELEASES.file: frame(RELEASES, ledger.rows),
        CHANGES.file: frame(CHANGES, changes),
        ENGINES.file: frame(ENGINES, map(engine_row, participants)),
        CONDITIONS.file: frame(CONDITIONS, conditions(command)),
    }
