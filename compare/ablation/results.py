"""All tables of an ablation, by file name."""

from collections.abc import Sequence

import pandas as pd

from compare.ablation.findings import ablation_findings
from compare.ablation.optional_features import Ablation
from compare.ablation.schemas import ABLATION
from compare.run.participants import Participant
from compare.run.provenance import conditions
from compare.tables.engines import engine_row
from compare.tables.frames import frame
from compare.tables.shared import CONDITIONS, ENGINES, FINDINGS


def ablation_tables(
    ablations: Sequence[Ablation], participants: Sequence[Participant], command: str
) -> dict[str, pd.DataFrame]:
    """Return every table by file name; command reruns them."""
    rows = [row for ablation in ablations for row in ablation.rows]
    return {
        "ablation.csv": frame(ABLATION, rows),
        "findings.csv": frame(FINDINGS, ablation_findings(rows)),
        "engines.csv": frame(ENGINES, map(engine_row, participants)),
        "conditions.csv": frame(CONDITIONS, conditions(command)),
    }
