"""The grade of one file: of its poses, and of its readings of a sensor."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from tumble.compare.grade.grade import Grade
from tumble.compare.grade.verdicts import RIGHT
from tumble.scenarios.scene import Scene

if TYPE_CHECKING:  # 20 ms, and most files have no readings
    from tumble.compare.grade.sensor_grade import SensorGrade


@dataclass(frozen=True, eq=False)
class FileGrade:
    """The grade of one file: of its poses, of its readings of a sensor, or of both.

    Parameters
    ----------
    pose : the grade of the trajectory; None: the file has no pose
    sensor : the grade of the readings; None: the file has none, or the scene has no sensor
    """

    pose: Grade | None
    sensor: "SensorGrade | None"

    @property
    def verdict(self) -> str:
        """The verdict: that of the poses, or that of the readings if the poses are right."""
        if self.pose is None or (self.sensor is not None and self.pose.verdict in RIGHT):
            assert self.sensor is not None
            return self.sensor.verdict
        return self.pose.verdict

    @property
    def file(self) -> str:
        """Name of the file."""
        return self._either.file

    @property
    def scene(self) -> Scene:
        """The scene that it is graded against."""
        return self._either.scene

    @property
    def _either(self) -> "Grade | SensorGrade":
        found = self.pose or self.sensor
        assert found is not None
        return found
