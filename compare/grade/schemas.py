"""The tables of a grade: one line a column."""

from dataclasses import dataclass
from typing import Annotated

from tumble.compare.tables.schema import Table
from tumble.compare.tables.shared import SceneName

File = Annotated[str, "the graded file"]
Verdict = Annotated[str, "verdict; docs/grade.md lists them"]


@dataclass(frozen=True)
class GradeRow:
    """One file: its vertex errors over all rows and vertices, their resolution, drifts where known, and the verdict."""

    file: File
    scene: SceneName
    read_as: Annotated[str, "description of the pose that was graded: pose, matrix or vertices"]
    rows: Annotated[int, "number of graded rows"]
    members: Annotated[int, "number of ensemble members (throws)"]
    verdict: Verdict
    max_error_m: Annotated[float, "largest vertex error, over rows and vertices"]
    at_t_s: Annotated[float, "time of the largest vertex error"]
    at_vertex: Annotated[int, "vertex with the largest error"]
    rms_error_m: Annotated[float, "root mean square vertex error, over rows and vertices"]
    final_error_m: Annotated[float, "largest vertex error in a member's last row"]
    resolution_m: Annotated[float, "resolution of the reference: smaller errors are indistinguishable from zero"]
    print_precision_m: Annotated[float, "largest position uncertainty from the file's printed digits"]
    energy_drift: Annotated[
        float | None, "largest difference from the true energy, over the largest kinetic energy; empty if unknown"
    ]
    momentum_drift: Annotated[
        float | None, "largest difference from the true momentum, over the largest true one; empty if unknown"
    ]
    angular_momentum_drift: Annotated[
        float | None, "largest difference from the true angular momentum, over the largest true one; empty if unknown"
    ]
    by_differences: Annotated[bool, "whether velocities are differences of positions, since the file has none"]


@dataclass(frozen=True)
class ExplanationRow:
    """One explanation and its residual: the best one with more and more of its mistakes, or one that fits as well."""

    file: File
    explanation: Annotated[str, "best, or alike if it fits as well as the best"]
    mistakes: Annotated[int, "number of mistakes in it"]
    what: Annotated[str, "the mistakes, in words"]
    max_residual_m: Annotated[float, "largest vertex error that it leaves, over the sampled rows"]
    rms_residual_m: Annotated[float, "root mean square vertex error that it leaves, over the sampled rows"]
    weight: Annotated[float, "information criterion (BIC): smaller is better, a difference of 10 is odds of 150 to 1"]


@dataclass(frozen=True)
class DiagnosisRow:
    """One parameter of one mistake; explanations of rank 2 and more fit as well as the one of rank 1."""

    file: File
    verdict: Verdict
    rank: Annotated[int, "1 for the best explanation"]
    engines: Annotated[str, "engines whose defaults are the best explanation, separated by |; empty if none"]
    mistake: Annotated[str, "name of the mistake; docs/mistakes.md lists them"]
    parameter: Annotated[str, "what the value is: step, time, rate, factor, choice, or a detail; empty if none"]
    value: Annotated[str, "a number, or a word"]
    unit: Annotated[str, "unit of the value; empty for a ratio or a word"]
    residual_m: Annotated[float, "largest vertex error that the explanation leaves, over the sampled rows"]


@dataclass(frozen=True)
class PartRow:
    """The largest error in one of 60 equal parts of the duration, over rows, members and vertices."""

    file: File
    from_s: Annotated[float, "start of the part"]
    to_s: Annotated[float, "end of the part"]
    max_error_m: Annotated[float, "largest vertex error in the part"]


@dataclass(frozen=True)
class SampleRow:
    """One vertex in one of the sampled rows of the member that is diagnosed."""

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
    error_x_m: Annotated[float, "x in the file minus the true x"]
    error_y_m: Annotated[float, "y in the file minus the true y"]
    error_z_m: Annotated[float, "z in the file minus the true z"]
    error_m: Annotated[float, "distance between the vertex in the file and the true one"]


Device = Annotated[str, "accelerometer or gyro"]
SensorName = Annotated[str, "name of the sensor in the scene"]
ReadingUnit = Annotated[str, "unit of the readings and their errors: m/s2 or rad/s"]


@dataclass(frozen=True)
class SensorGradeRow:
    """One device of a sensor: the errors of its readings, over all rows that are not at an impulse, and the verdict."""

    file: File
    scene: SceneName
    sensor: SensorName
    device: Device
    unit: ReadingUnit
    rows: Annotated[int, "number of graded rows"]
    rows_at_impulses: Annotated[int, "number of rows left out, since an impulse acts next to them"]
    verdict: Verdict
    max_error: Annotated[float, "largest error, length of the vector of three axes"]
    at_t_s: Annotated[float, "time of the largest error"]
    rms_error: Annotated[float, "root mean square error, length of the vector of three axes"]
    residual: Annotated[float, "root mean square that the best explanation leaves; rms_error if there is none"]
    resolution: Annotated[float, "resolution of the reference: smaller errors are indistinguishable from zero"]
    print_precision: Annotated[float, "largest uncertainty from the file's printed digits"]
    hidden: Annotated[str, "mistakes that the noise of the file would hide, separated by |; empty if none"]


@dataclass(frozen=True)
class SensorDiagnosisRow:
    """One parameter of one mistake of a sensor; explanations of rank 2 and more fit as well as the one of rank 1."""

    file: File
    sensor: SensorName
    device: Device
    rank: Annotated[int, "1 for the best explanation of the device"]
    mistake: Annotated[str, "name of the mistake; docs/mistakes.md lists them"]
    parameter: Annotated[str, "what the value is: time, factor, share, rows, choice, x, y or z; empty if none"]
    value: Annotated[str, "a number, or a word"]
    unit: Annotated[str, "unit of the value; empty for a ratio or a word"]
    residual: Annotated[float, "root mean square that the explanation leaves, in the unit of the readings"]


@dataclass(frozen=True)
class ReadingRow:
    """One reading of a device, in the sensor's axes: of many rows, some that are spread evenly."""

    file: File
    scene: SceneName
    sensor: SensorName
    device: Device
    unit: ReadingUnit
    t_s: Annotated[float, "time of the row"]
    true_x: Annotated[float, "true x of the reading"]
    true_y: Annotated[float, "true y of the reading"]
    true_z: Annotated[float, "true z of the reading"]
    x: Annotated[float, "x of the reading in the file"]
    y: Annotated[float, "y of the reading in the file"]
    z: Annotated[float, "z of the reading in the file"]
    error: Annotated[float, "length of the difference"]


@dataclass(frozen=True)
class ContactGradeRow:
    """One observable of an impact or of a motion along the plane: in the file, and by the scene's law."""

    file: File
    scene: SceneName
    member: Annotated[int, "number of the ensemble member"]
    t_s: Annotated[float, "time of the impact, or at which the motion along the plane begins"]
    observable: Annotated[str, "what is measured, in words"]
    unit: Annotated[str, "unit of value and expected; empty for a ratio"]
    value: Annotated[float, "value in the file"]
    expected: Annotated[float, "value by the scene's law, from the state in the file just before"]


@dataclass(frozen=True)
class ContactDiagnosisRow:
    """One parameter of one mistake of contact; explanations of rank 2 and more fit as well as the one of rank 1."""

    file: File
    verdict: Verdict
    rank: Annotated[int, "1 for the best explanation"]
    mistake: Annotated[str, "name of the mistake; docs/mistakes.md lists them"]
    parameter: Annotated[str, "what the value is: factor, speed, rate, step, gap or a tilt; empty if none"]
    value: Annotated[str, "a number; empty if none"]
    unit: Annotated[str, "unit of the value; empty for a ratio"]
    residual: Annotated[
        float, "largest error that it leaves, over impacts and motions, in units of what step and digits allow"
    ]


GRADE = Table("grade.csv", GradeRow, ("file",))
EXPLANATIONS = Table("explanations.csv", ExplanationRow)
DIAGNOSIS = Table("diagnosis.csv", DiagnosisRow)
PARTS = Table("grade-parts.csv", PartRow, ("file", "from_s"))
VERTICES = Table("grade-vertices.csv", SampleRow, ("file", "member", "t_s", "vertex"))
SENSOR_GRADE = Table("sensor-grade.csv", SensorGradeRow, ("file", "sensor", "device"))
SENSOR_DIAGNOSIS = Table("sensor-diagnosis.csv", SensorDiagnosisRow)
READINGS = Table("grade-readings.csv", ReadingRow, ("file", "sensor", "device", "t_s"))
CONTACT_GRADE = Table("contact-grade.csv", ContactGradeRow)
CONTACT_DIAGNOSIS = Table("contact-diagnosis.csv", ContactDiagnosisRow)
TABLES = (
    GRADE,
    DIAGNOSIS,
    EXPLANATIONS,
    PARTS,
    VERTICES,
    CONTACT_GRADE,
    CONTACT_DIAGNOSIS,
    SENSOR_GRADE,
    SENSOR_DIAGNOSIS,
    READINGS,
)
