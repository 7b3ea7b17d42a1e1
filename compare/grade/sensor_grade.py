"""Grades the readings of one sensor in a file: their errors, the mistakes that explain them, and a verdict."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

from tumble.compare.grade.grade import (
    COARSE,
    CORRECT_TO_DIGITS,
    CORRECT_TO_NOISE,
    CORRECT_TO_RESOLUTION,
    CORRECT_TO_SINGLE,
    EXPLAINED_PARTLY,
    EXPLAINED_WHOLLY,
    LITTLE,
    MOST_LEFT,
    TOO_COARSE,
    TOO_FEW,
    TOO_LITTLE,
    UNEXPLAINED,
)
from tumble.compare.grade.measure.readings import MeasuredReadings, measure_readings, read_readings
from tumble.compare.grade.model.kinematics import Motion, TrueMotion
from tumble.compare.grade.model.reference import Reference
from tumble.compare.grade.model.sensor_model import right_model
from tumble.compare.grade.read.columns import BadTrajectory
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.compare.grade.search.sensor_search import SensorDiagnosis, SensorExplanation, SensorMistake, SensorSearch
from tumble.compare.run.progress import Progress, ProgressCallback, no_progress
from tumble.scenarios.format import short
from tumble.scenarios.scene import Scene, Sensor

NO_MISTAKE_SEEN = "no mistake above its noise"
# Fewer rows determine no mistake.
FEWEST_ROWS = 8
# An error of the attitude by an angle changes a reading by at most this many times that share of it.
BY_ATTITUDE = 10.0
RIGHT = (CORRECT_TO_RESOLUTION, CORRECT_TO_SINGLE, CORRECT_TO_DIGITS, CORRECT_TO_NOISE)
# The verdicts of a file, of which the last one among its devices counts.
UNDECIDED = (NO_MISTAKE_SEEN, TOO_COARSE, TOO_LITTLE, TOO_FEW)


@dataclass(frozen=True, eq=False)
class DeviceGrade:
    """The grade of an accelerometer's or a gyro's readings.

    Parameters
    ----------
    measured : the errors
    diagnosis : explanations of the errors; None: none was searched for
    hidden : mistakes that the noise of the file would hide
    """

    measured: MeasuredReadings
    diagnosis: SensorDiagnosis | None
    hidden: tuple[SensorMistake, ...] = ()

    @cached_property
    def verdict(self) -> str:
        """One of the verdicts of docs/grade.md."""
        m, diagnosis = self.measured, self.diagnosis
        if m.worst <= m.resolution:
            return CORRECT_TO_RESOLUTION
        if m.excess <= 0:
            coarse = m.half > COARSE * m.size
            return TOO_COARSE if coarse else CORRECT_TO_SINGLE if m.single else CORRECT_TO_DIGITS
        if diagnosis is None:
            return TOO_FEW
        if not diagnosis.best.mistakes:
            if diagnosis.null.is_noise:
                return NO_MISTAKE_SEEN if self.hidden else CORRECT_TO_NOISE
            return TOO_LITTLE if m.worst <= LITTLE * m.size else UNEXPLAINED
        if diagnosis.best.is_whole:
            return EXPLAINED_WHOLLY
        return EXPLAINED_PARTLY if diagnosis.best.rms <= MOST_LEFT * diagnosis.null.rms else UNEXPLAINED

    @property
    def is_right(self) -> bool:
        """Whether it is correct to what the file can show."""
        return self.verdict in RIGHT

    @property
    def mistakes(self) -> tuple[SensorMistake, ...]:
        """The mistakes of the best explanation."""
        named = self.verdict in (EXPLAINED_WHOLLY, EXPLAINED_PARTLY)
        return self.diagnosis.best.mistakes if named and self.diagnosis else ()


@dataclass(frozen=True, eq=False)
class SensorGrade:
    """The grade of the readings of one sensor.

    Parameters
    ----------
    file : name of the file
    scene : the scene
    sensor : the sensor of the scene
    devices : grades of its accelerometer and gyro, as far as the file has them
    """

    file: str
    scene: Scene
    sensor: Sensor
    devices: tuple[DeviceGrade, ...]

    @cached_property
    def verdict(self) -> str:
        """The verdict of the file: that of its devices that are wrong, else the weakest one."""
        verdicts = [each.verdict for each in self.devices]
        wrong = [each for each in verdicts if each in (EXPLAINED_WHOLLY, EXPLAINED_PARTLY, UNEXPLAINED)]
        if wrong:
            return wrong[0] if len(set(wrong)) == 1 else EXPLAINED_PARTLY
        return max(verdicts, key=(*RIGHT, *UNDECIDED).index)


def chosen_sensor(scene: Scene, name: str | None) -> Sensor:
    """Return the sensor of a scene that a file is of.

    Parameters
    ----------
    scene : the scene
    name : its name; None: the scene's only one

    Returns
    -------
    the sensor

    Raises
    ------
    BadTrajectory : there is none, it has no such sensor, or several; or the sensor reads a magnetic field
    """
    names = ", ".join(short(sensor.name) for sensor in scene.sensors)
    if not scene.sensors:
        raise BadTrajectory(
            f"{scene.name} has no sensor: declare it in the scene file, e.g. [[sensor]] with name = \"imu\", "
            'kind = "imu", rate = 100.0 and point = [0.1, 0.0, 0.0]'
        )
    if name is None and len(scene.sensors) > 1:
        raise BadTrajectory(f"{scene.name} has several sensors: give one of them with --sensor NAME: {names}")
    found = [sensor for sensor in scene.sensors if name in (None, sensor.name)]
    if not found:
        raise BadTrajectory(f"--sensor {short(str(name))}: {scene.name} has no such sensor, only {names}")
    if not (found[0].reads_force or found[0].reads_spin):
        raise BadTrajectory(
            f"--sensor {short(found[0].name)}: {found[0].kind} cannot be graded, only an accelerometer or a gyro"
        )
    return found[0]


def grade_readings(
    trajectory: Trajectory,
    scene: Scene,
    sensor: Sensor,
    on_measured: Callable[[Sequence[MeasuredReadings]], object] = lambda measured: None,
    on_progress: ProgressCallback = no_progress,
) -> SensorGrade:
    """Grade the readings of one sensor.

    Parameters
    ----------
    trajectory : the file
    scene, sensor : the scene that it is graded against, and its sensor
    on_measured : called with the errors of each device, before a search
    on_progress : called with the shares of the tasks: rows, truth, search

    Returns
    -------
    the grade

    Raises
    ------
    BadTrajectory : a row cannot be read
    NoTruth : the scene has no reference solution over the file's duration
    """
    throws = read_readings(trajectory)
    working, searching = Progress(f"{scene.name} truth", on_progress), Progress("search", on_progress)
    found: dict[str, tuple[MeasuredReadings, Motion]] = {}
    for throw, devices in throws.items():
        motion = TrueMotion(scene, throw)
        times = next(iter(devices.values())).times
        share = Reference(scene).resolution(throw, times, working) / scene.body.reach
        for device, readings in devices.items():
            single = all(trajectory.digits[name].single for name in trajectory.devices[device]) and any(
                trajectory.digits[name].is_decisive for name in trajectory.devices[device]
            )
            model = right_model(sensor, device)
            measured = measure_readings(readings, model, motion, scene, single, BY_ATTITUDE * share, throw)
            if device not in found or measured.worst > found[device][0].worst:
                found[device] = measured, motion
    working.end()
    if any(measured.excess > 0 for measured, _ in found.values()):
        on_measured([measured for measured, _ in found.values()])
    grades = []
    for number, (device, (measured, motion)) in enumerate(found.items(), 1):
        diagnosis, hidden = None, ()
        if measured.excess > 0 and len(measured.readings) >= FEWEST_ROWS:
            search = SensorSearch(measured, right_model(sensor, device), motion)
            diagnosis = search.diagnosis()
            if diagnosis.null.is_noise and not diagnosis.best.mistakes:
                hidden = search.hidden(diagnosis.null)
        grades.append(DeviceGrade(measured, diagnosis, hidden))
        searching(number / len(found))
    searching.end()
    return SensorGrade(trajectory.name, scene, sensor, tuple(agreeing(grades)))


def agreeing(grades: Sequence[DeviceGrade]) -> list[DeviceGrade]:
    """Return the grades of devices, with equally good explanations exchanged where another device has the same one."""
    found = list(grades)
    for number, grade in enumerate(grades):
        diagnosis = grade.diagnosis
        others = {mistake.hypothesis.name for other in grades if other is not grade for mistake in other.mistakes}
        if diagnosis is None or not grade.mistakes or not others:
            continue
        every: list[SensorExplanation] = [diagnosis.best, *diagnosis.alike]
        best = max(every, key=lambda each: len(each.names & others) - len(each.names))
        if best is not diagnosis.best and len(best.names & others) > len(diagnosis.best.names & others):
            rest = tuple(each for each in every if each is not best)
            found[number] = DeviceGrade(
                grade.measured, SensorDiagnosis(diagnosis.null, best, rest, diagnosis.trials), grade.hidden
            )
    return found

