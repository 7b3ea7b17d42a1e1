"""The tables of contact, from the contestants' results."""

from collections.abc import Iterable

import pandas as pd

from tumble.compare.contact.findings import contact_findings
from tumble.compare.contact.rows import contact_rows, scan_rows
from tumble.compare.contact.schemas import CONTACT, SCANS
from tumble.compare.contact.study import Contact
from tumble.compare.tables.frames import frame
from tumble.compare.tables.shared import FINDINGS


def contact_tables(contacts: Iterable[Contact]) -> dict[str, pd.DataFrame]:
    """Return the tables of contact.

    Parameters
    ----------
    contacts : results of contestants

    Returns
    -------
    table by file name; none where there are no results
    """
    contacts = list(contacts)
    if not contacts:
        return {}
    rows = [row for one in contacts for row in contact_rows(one)]
    return {
        CONTACT.file: frame(CONTACT, rows),
        SCANS.file: frame(SCANS, (row for one in contacts for row in scan_rows(one))),
        FINDINGS.file: frame(FINDINGS, contact_findings(rows)),
    }
