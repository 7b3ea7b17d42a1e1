"""All tables of a ledger, by file name."""

from collections.abc import Sequence

import pandas as pd

from tumble.compare.contact.schemas import CONTACT
from tumble.compare.releases.ledger import Ledger
from tumble.compare.releases.schemas import CHANGES, RELEASES, ReleaseChangeRow
from tumble.compare.run.provenance import conditions
from tumble.compare.tables.frames import frame
from tumble.compare.tables.shared import CONDITIONS, ENGINES, EngineRow


def ledger_tables(
    ledger: Ledger, changes: Sequence[ReleaseChangeRow], engines: Sequence[EngineRow], command: str
) -> dict[str, pd.DataFrame]:
    """Return all tables of a ledger; contact.csv only if a scene has a plane.

    Parameters
    ----------
    ledger : of one engine
    changes : what changed at each release
    engines : the releases, as engines
    command : the command line that repeats the study, for conditions.csv

    Returns
    -------
    table by file name
    """
    observed = [row for rows in ledger.contact.values() for row in rows]
    return {
        **({CONTACT.file: frame(CONTACT, observed)} if observed else {}),
        RELEASES.file: frame(RELEASES, ledger.rows),
        CHANGES.file: frame(CHANGES, changes),
        ENGINES.file: frame(ENGINES, engines),
        CONDITIONS.file: frame(CONDITIONS, conditions(command)),
    }
