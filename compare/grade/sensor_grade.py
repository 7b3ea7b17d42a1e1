"""Grades the readings of one sensor in a file: their errors, the mistakes that explain them, and a verdict."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tumble.compare.grade.grade import COARSE, LEFT_AS_NOISE, LITTLE, MOST_LEFT, Grade
from tumble.compare.grade.measure.own_motion import own_motion
from tumble.compare.grade.measure.readings import (
    MeasuredReadings,
    certified,
    measure_readings,
    model_readings,
    read_readings,
)
from tumble.compare.grade.model.kinematics import Motion, TrueMotion
from tumble.compare.grade.model.program_motion import ProgramMotion
from tumble.compare.grade.model.sensor_model import ACCELEROMETER, right_model
from tumble.compare.grade.read.columns import BadTrajectory
from tumble.compare.grade.read.trajectory import Trajectory, without_sensor
from tumble.compare.grade.search.sensor_search import SensorDiagnosis, SensorExplanation, SensorMistake, SensorSearch
from tumble.compare.grade.verdicts import (
    CORRECT_TO_DIGITS,
    CORRECT_TO_NOISE,
    CORRECT_TO_RESOLUTION,
    CORRECT_TO_SINGLE,
    EXPLAINED_PARTLY,
    EXPLAINED_WHOLLY,
    FOLLOWS_MOTION,
    NO_MISTAKE_SEEN,
    RIGHT,
    TOO_COARSE,
    TOO_FEW,
    TOO_LITTLE,
    UNEXPLAINED,
)
from tumble.compare.run.progress import Progress, ProgressCallback, no_progress
from tumble.scenarios.format import short
from tumble.scenarios.scene import Scene, Sensor, frozen_array
from tumble.scenarios.truth import NoTruth
from tumble.scenarios.truth.sensors import sensor_truth

# Readings follow the motion in the file if they are off from it by this share of their true error.
FOLLOWS = 0.1
# Fewer rows determine no mistake.
FEWEST_ROWS = 8
# The spline through every second row is off by at least this many times as much as that through all.
COARSER = 4.0
# Times at which the readings of the quick motion are compared with the truth.
CERTIFIED = 12
# The verdicts of a file, of which the last one among its devices counts.
UNDECIDED = (FOLLOWS_MOTION, NO_MISTAKE_SEEN, TOO_COARSE, TOO_LITTLE, TOO_FEW)


@dataclass(frozen=True, eq=False)
class DeviceGrade:
    """The grade of an accelerometer's or a gyro's readings.

    Parameters
    ----------
    measured : the errors
    diagnosis : explanations of the errors, against the motion in the file if `own` is given; None: not searched for
    hidden : mistakes that the noise of the file would hide
    own : the errors against what the motion in the file implies; None: that motion is right, or not in the file
    """

    measured: MeasuredReadings
    diagnosis: SensorDiagnosis | None
    hidden: tuple[SensorMistake, ...] = ()
    own: MeasuredReadings | None = None

    @cached_property
    def verdict(self) -> str:
        """One of the verdicts of docs/grade.md."""
        m, diagnosis = self.measured, self.diagnosis
        if m.worst <= m.resolution:
            return CORRECT_TO_RESOLUTION
        if m.excess <= 0:
            coarse = m.half > COARSE * m.size
            return TOO_COARSE if coarse else CORRECT_TO_SINGLE if m.single else CORRECT_TO_DIGITS
        if self.own is not None and self._follows_own:
            return FOLLOWS_MOTION
        if diagnosis is None:
            return TOO_FEW
        if not diagnosis.best.mistakes:
            if diagnosis.null.is_noise:
                return NO_MISTAKE_SEEN if self.hidden else CORRECT_TO_NOISE
            return TOO_LITTLE if m.worst <= LITTLE * m.size else UNEXPLAINED
        if diagnosis.best.is_whole:
            return EXPLAINED_WHOLLY
        # Any fitted value explains a part of the error of a wrong motion.
        has_number = any(mistake.hypothesis.fitted or mistake.fitted for mistake in diagnosis.best.mistakes)
        most_left = LEFT_AS_NOISE if has_number else MOST_LEFT
        return EXPLAINED_PARTLY if diagnosis.best.rms <= most_left * diagnosis.null.rms else UNEXPLAINED

    @property
    def _follows_own(self) -> bool:
        """Whether the readings are right for the motion in the file."""
        own, diagnosis = self.own, self.diagnosis
        assert own is not None
        if own.excess <= 0 or diagnosis is None:
            return own.excess <= 0
        if diagnosis.best.mistakes and diagnosis.best.is_whole:
            return False
        return own.rms <= FOLLOWS * self.measured.rms or diagnosis.null.is_noise

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
        raise without_sensor(scene)
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
    pose: Grade | None = None,
) -> SensorGrade:
    """Grade the readings of one sensor.

    Parameters
    ----------
    trajectory : the file
    scene, sensor : the scene that it is graded against, and its sensor
    on_measured : called with the errors of each device, before a search
    on_progress : called with the shares of the tasks: rows, truth, search
    pose : the grade of the poses in the file; if they are wrong, mistakes are sought against their own motion

    Returns
    -------
    the grade

    Raises
    ------
    BadTrajectory : a row cannot be read
    NoTruth : the scene has no reference solution over the file's duration
    """
    searching = Progress("search", on_progress)
    found: dict[str, tuple[MeasuredReadings, Motion]] = {}
    for throw, devices in read_readings(trajectory).items():
        motion = TrueMotion(scene, throw)
        for device, readings in devices.items():
            measured = measure_readings(readings, right_model(sensor, device), motion, scene, throw)
            if device not in found or measured.worst > found[device][0].worst:
                found[device] = measured, motion
    if wrong := [measured for measured, _ in found.values() if measured.excess > 0]:
        on_measured(wrong)
    for device, (measured, motion) in found.items():
        error = reference_error(scene, sensor, measured, motion)
        found[device] = certified(measured, error, is_single(trajectory, device)), motion
    on_progress(f"{scene.name} truth")
    grades = []
    for number, (device, (measured, motion)) in enumerate(found.items(), 1):
        diagnosis, hidden, judged = None, (), measured
        own = None
        if pose is not None and pose.verdict not in RIGHT and measured.excess > 0:
            own = against_own(trajectory, measured, sensor, pose)
        if own is not None:
            judged, motion = own
        if judged.excess > 0 and len(judged.readings) >= FEWEST_ROWS:
            search = SensorSearch(judged, right_model(sensor, device), motion)
            diagnosis = search.diagnosis()
            if diagnosis.null.is_noise and not diagnosis.best.mistakes:
                hidden = search.hidden(diagnosis.null)
        grades.append(DeviceGrade(measured, diagnosis, hidden, own[0] if own else None))
        searching(number / len(found))
    searching.end()
    return SensorGrade(trajectory.name, scene, sensor, tuple(agreeing(grades)))


def against_own(
    trajectory: Trajectory, measured: MeasuredReadings, sensor: Sensor, pose: Grade
) -> tuple[MeasuredReadings, Motion] | None:
    """Return the errors against what the motion in the file implies, and this motion; None if it is not in the file.

    The motion is that of the program that explains the poses, else a spline through them.
    """
    readings, model, scene = measured.readings, right_model(sensor, measured.device), pose.scene
    if pose.verdict == EXPLAINED_WHOLLY and pose.diagnosis and pose.measured.throw == measured.throw:
        simulated = ProgramMotion(pose.diagnosis.program, scene)
        return measure_readings(readings, model, simulated, scene, measured.throw), simulated
    motion = own_motion(trajectory, measured.throw, scene)
    if motion is None:
        return None
    implied, coarsely = (model_readings(model, each, readings.times) for each in (motion, motion.coarser()))
    usable = np.isfinite(implied + coarsely).all(axis=1) & motion.inner_rows(readings.times, 2 * readings.spacing_s)
    if usable.sum() < FEWEST_ROWS:
        return None
    error = float(np.linalg.norm(implied - coarsely, axis=1)[usable].max()) / COARSER
    own = measure_readings(readings.some(usable), model, motion, scene, measured.throw)
    return certified(own, error, measured.single), motion


def is_single(trajectory: Trajectory, device: str) -> bool:
    """Return whether every reading of a device is printed as a number of single precision."""
    printed = [trajectory.digits[name] for name in trajectory.devices[device]]
    return all(each.single for each in printed) and any(each.is_decisive for each in printed)


def reference_error(scene: Scene, sensor: Sensor, measured: MeasuredReadings, motion: Motion) -> float:
    """Return the error of the quick motion's readings against the truth's at a dozen times [m/s2 or rad/s].

    Raises NoTruth.
    """
    times, device = measured.readings.times, measured.device
    usable = times[~np.isin(times, [impulse.time for impulse in scene.impulses])]
    some = usable[np.unique(np.linspace(0, len(usable) - 1, CERTIFIED).round().astype(int))]
    start = frozen_array(scene.start[measured.throw : measured.throw + 1])
    instantly = replace(sensor, average=False)
    true = sensor_truth(replace(scene, start=start, times=frozen_array(some)), instantly, some)
    place, values = (0, true.specific_force) if device == ACCELEROMETER else (1, true.angular_velocity)
    if not np.isfinite(values).all():
        raise NoTruth(f"the readings of {short(sensor.name)} have no reference: {next(filter(None, true.why))}")
    apart = model_readings(right_model(instantly, device), motion, some) - values[:, 0]
    return float(np.linalg.norm(apart, axis=1).max() + true.resolution[:, 0, place].max())


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
            found[number] = replace(grade, diagnosis=SensorDiagnosis(diagnosis.null, best, rest, diagnosis.trials))
    return found
