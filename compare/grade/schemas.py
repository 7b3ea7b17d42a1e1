"""The tables of a grade: one line a column."""

from dataclasses import dataclass
from typing import Annotated

from tumble.compare.tables.schema import Table
from tumble.compare.tables.shared import SceneName

File = Annotated[str, "the file that was graded"]


@dataclass(frozen=True)
class GradeRow:
    """One file: errors over all rows and vertices, what they are held against, drifts where known, and the verdict."""

    file: File
    scene: SceneName
    read_as: Annotated[str, "what was graded: pose, matrix or vertices"]
    rows: Annotated[int, "rows that were graded"]
    members: Annotated[int, "number of ensemble members (throws)"]
    verdict: Annotated[str, "what was found"]
    max_error_m: Annotated[float, "largest vertex error"]
    at_t_s: Annotated[float, "when that is"]
    at_vertex: Annotated[int, "at which vertex"]
    rms_error_m: Annotated[float, "root mean square over all rows and vertices"]
    final_error_m: Annotated[float, "largest vertex error of the last row"]
    resolution_m: Annotated[float, "what the truth can tell"]
    print_precision_m: Annotated[float, "what the digits of the file can tell"]
    energy_drift: Annotated[float | None, "largest difference from the true energy, over the largest kinetic"]
    momentum_drift: Annotated[float | None, "largest difference from the true momentum, over the largest"]
    angular_momentum_drift: Annotated[
        float | None, "largest difference from the true angular momentum, over the largest"
    ]
    by_differences: Annotated[bool, "whether velocities were taken from differences of positions"]


@dataclass(frozen=True)
class ExplanationRow:
    """One explanation: `best` by so many of its mistakes, or one that fits alike; what it leaves of the rows kept."""

    file: File
    explanation: Annotated[str, "best or alike"]
    mistakes: Annotated[int, "number of mistakes in it"]
    what: Annotated[str, "what they are"]
    max_residual_m: Annotated[float, "largest vertex error that it leaves"]
    rms_residual_m: Annotated[float, "root mean square of what it leaves"]
    weight: Annotated[float, "how much it is worth beside the others"]


@dataclass(frozen=True)
class DiagnosisRow:
    """One number, or word, of one mistake: rank 1 is the best explanation, and those of one group fit alike."""

    file: File
    verdict: Annotated[str, "what was found"]
    rank: Annotated[int, "1 for the best explanation"]
    group: Annotated[int, "explanations that cannot be told from one another share it"]
    engines: Annotated[str, "engines that do the same at their defaults, of the best explanation"]
    mistake: Annotated[str, "stable name of a mistake, docs/mistakes.md lists them"]
    parameter: Annotated[str, "what the value is: step, time, rate, factor, choice, or a detail"]
    value: Annotated[str, "a number, or a word"]
    unit: Annotated[str, "of the number"]
    residual_m: Annotated[float, "largest vertex error that the explanation leaves"]


@dataclass(frozen=True)
class PartRow:
    """The largest error in one of equal parts of the duration, over all rows, throws and vertices."""

    file: File
    from_s: Annotated[float, "begin of the part"]
    to_s: Annotated[float, "end of the part"]
    max_error_m: Annotated[float, "largest vertex error in it"]


@dataclass(frozen=True)
class KeptRow:
    """One vertex at one of the rows kept of the throw that is diagnosed."""

    file: File
    scene: SceneName
    member: Annotated[int, "number of the ensemble member"]
    t_s: Annotated[float, "time of the row"]
    vertex: Annotated[int, "number of the vertex"]
    true_x_m: Annotated[float, "true x of the vertex, world axes"]
    true_y_m: Annotated[float, "true y of the vertex, world axes"]
    true_z_m: Annotated[float, "true z of the vertex, world axes"]
    x_m: Annotated[float, "x of the vertex in the file, world axes"]
    y_m: Annotated[float, "y of the vertex in the file, world axes"]
    z_m: Annotated[float, "z of the vertex in the file, world axes"]
    error_x_m: Annotated[float, "x in the file less the true x"]
    error_y_m: Annotated[float, "y in the file less the true y"]
    error_z_m: Annotated[float, "z in the file less the true z"]
    error_m: Annotated[float, "distance of the vertex in the file from the true one"]


GRADE = Table("grade.csv", GradeRow, ("file",))
EXPLANATIONS = Table("explanations.csv", ExplanationRow)
DIAGNOSIS = Table("diagnosis.csv", DiagnosisRow)
PARTS = Table("grade-parts.csv", PartRow, ("file", "from_s"))
VERTICES = Table("grade-vertices.csv", KeptRow, ("file", "member", "t_s", "vertex"))
TABLES = (GRADE, DIAGNOSIS, EXPLANATIONS, PARTS, VERTICES)
