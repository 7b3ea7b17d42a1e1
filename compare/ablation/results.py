"""All tables of an ablation, by file name."""

from collections.abc import Sequence

import pandas as pd

from tumble.compare.ablation.findings import ablation_findings
from tumble.compare.ablation.optional_features import Ablation
from tumble.compare.ablation.schemas import ABLATION
from tumble.compare.run.provenance import conditions
from tumble.compare.tables.frames import frame
from tumble.compare.tables.shared import CONDITIONS, ENGINES, FINDINGS, EngineRow


def ablation_tables(
    ablations: Sequence[Ablation], engines: Sequence[EngineRow], command: str
) -> dict[str, pd.DataFrame]:
    """Return all tables of ablations.

    Parameters
    ----------
    ablations : of the scenes
    engines : that took part
    command : the command line that repeats the study, for conditions.csv

    Returns
    -------
    table by file name
    """
    rows = [row for ablation in ablations for row in ablation.rows]
    return {
        "ablation.csv": frame(ABLATION, rows),
        "findings.csv": frame(FINDINGS, ablation_findings(rows)),
        "engines.csv": frame(ENGINES, engines),
        "conditions.csv": frame(CONDITIONS, conditions(command)),
    }
