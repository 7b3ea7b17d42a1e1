"""A program that simulates an IMU as students and engine teams write one, with a switch for each mistake.

It imports nothing of ours.  The motion is that of the angular momentum in world axes, integrated by scipy; the specific
force comes from world axes, where the point's acceleration is a + alpha x (R r) + w x (w x R r).  `random_scene` draws
scenes, and `random_mistakes` what is wrong in a file.
"""

import csv
from dataclasses import dataclass, fields

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

STANDARD_GRAVITY = 9.80665


@dataclass(frozen=True)
class Imu:
    """What a program makes of the readings: as it stands everything is right.

    centripetal, tangential, gravity: factors of the terms; rotating: the velocity is differentiated in body axes;
    axes: sensor, world, or transposed; late: rows; accelerometer_unit, gyro_unit: factors; order: of the axes written,
    with signs; point: added to the sensor's [m]; share: of a low-pass filter's new row; noise: of the accelerometer
    [m/s2] and the gyro [rad/s]; digits: significant ones, 0 for all.
    """

    centripetal: float = 1.0
    tangential: float = 1.0
    gravity: float = 1.0
    rotating: bool = False
    axes: str = "sensor"
    late: int = 0
    accelerometer_unit: float = 1.0
    gyro_unit: float = 1.0
    order: tuple = (1, 2, 3)
    point: tuple = (0.0, 0.0, 0.0)
    share: float = 1.0
    noise: tuple = (0.0, 0.0)
    digits: int = 0


# The twelve mistakes of the issue (gravity's three count as one), by the name that grade has for each.
MISTAKES = {
    "sensor-centripetal-term-missing": {"centripetal": 0.0},
    "sensor-tangential-term-missing": {"tangential": 0.0},
    "sensor-gravity-missing": {"gravity": 0.0},
    "sensor-gravity-doubled": {"gravity": 2.0},
    "sensor-gravity-reversed": {"gravity": -1.0},
    "sensor-in-world-axes": {"axes": "world"},
    "sensor-attitude-transposed": {"axes": "transposed"},
    "sensor-differentiated-in-rotating-frame": {"rotating": True},
    "sensor-late": {"late": 1},
    "sensor-in-g": {"accelerometer_unit": 1 / STANDARD_GRAVITY},
    "sensor-in-degrees": {"gyro_unit": 180 / np.pi},
    "sensor-axes-permuted": {"order": (2, 3, 1)},
    "sensor-axes-left-handed": {"order": (1, -2, 3)},
    "sensor-at-wrong-point": {"point": (0.05, -0.03, 0.02)},
    "sensor-low-pass": {"share": 0.3},
}


class Motion:
    """The motion of a box under gravity, drag and impulses, of a scene as a dictionary of its TOML file."""

    def __init__(self, scene: dict) -> None:
        body, drag = scene["body"], scene.get("drag", {})
        self.mass, edges = body["mass"], np.array(body["size"])
        self.inertia = self.mass / 12 * (np.sum(edges**2) - edges**2)
        self.gravity = np.array(scene.get("gravity", (0.0, 0.0, 0.0)))
        self.linear, self.angular = drag.get("linear", 0.0), drag.get("angular", 0.0)
        turn = rotation(body.get("orientation", (1, 0, 0, 0)))
        momentum = turn @ (self.inertia * (turn.T @ np.array(body["angular_velocity"])))
        state = np.concatenate((body.get("position", (0.0,) * 3), body["velocity"], turn.ravel(), momentum))
        self.pieces, begin = [], 0.0
        for hit in [*scene.get("impulse", []), {"time": scene["duration"]}]:
            if hit["time"] > begin:
                found = solve_ivp(
                    self.rates, (begin, hit["time"]), state, "DOP853", dense_output=True, rtol=1e-12, atol=1e-12
                )
                self.pieces.append((begin, found.sol))
                state, begin = found.y[:, -1].copy(), hit["time"]
            if "value" in hit:
                turn, push = state[6:15].reshape(3, 3), np.array(hit["value"])
                state[3:6] += push / self.mass
                state[15:18] += np.cross(turn @ np.array(hit["point_body"]), push)

    def spin(self, state):
        """Return R and w in world axes."""
        turn = state[6:15].reshape(3, 3)
        return turn, turn @ ((turn.T @ state[15:18]) / self.inertia)

    def rates(self, t, state):
        """Return the derivative of x, v, R and L."""
        turn, w = self.spin(state)
        a = self.gravity - self.linear / self.mass * state[3:6]
        return np.concatenate((state[3:6], a, np.cross(w, turn.T).T.ravel(), -self.angular * w))

    def at(self, t):
        """Return R, v, a, w and alpha in world axes."""
        sol = [piece for begin, piece in self.pieces if begin <= t][-1]
        state = sol(t)
        turn, w = self.spin(state)
        rates = self.rates(t, state)
        torque = rates[15:18] - np.cross(w, state[15:18])
        return turn, state[3:6], rates[3:6], w, turn @ ((turn.T @ torque) / self.inertia)


def rotation(wxyz) -> np.ndarray:
    """Return the matrix of a quaternion w x y z."""
    return Rotation.from_quat(np.roll(np.array(wxyz, dtype=float), -1)).as_matrix()


def readings(scene: dict, motion: Motion, times: np.ndarray, program: Imu, rng: np.random.Generator) -> np.ndarray:
    """Return what the program reads at times [s], (T, 6): accelerometer and gyro."""
    sensor, period = scene["sensor"][0], float(times[1] - times[0])
    mount = rotation(sensor.get("orientation", (1, 0, 0, 0)))
    point = np.array(sensor.get("point", (0.0, 0.0, 0.0))) + program.point
    rows = []
    for t in times:
        turn, v, a, w, alpha = motion.at(max(t - program.late * period, 0.0))
        arm = turn @ point
        force = a - program.gravity * motion.gravity
        force = force + program.tangential * np.cross(alpha, arm) + program.centripetal * np.cross(w, np.cross(w, arm))
        if program.rotating:
            force = force - np.cross(w, v + np.cross(w, arm))
        to_axes = {"sensor": turn.T, "world": np.eye(3), "transposed": turn}[program.axes]
        rows.append((mount.T @ to_axes @ force, mount.T @ to_axes @ w))
    both = np.array(rows)
    both[:, 0] *= program.accelerometer_unit
    both[:, 1] *= program.gyro_unit
    order = np.array(program.order)
    both = np.sign(order) * both[:, :, np.abs(order) - 1]
    for k in range(1, len(both)):
        both[k] = both[k - 1] + program.share * (both[k] - both[k - 1])
    both += np.array(program.noise)[:, None] * rng.standard_normal(both.shape)
    return both.reshape(-1, 6)


def write(path, times: np.ndarray, rows: np.ndarray, digits: int = 0) -> None:
    """Write readings as CSV."""
    with open(path, "w", newline="") as file:
        out = csv.writer(file)
        out.writerow(("t_s", "ax_m_s2", "ay_m_s2", "az_m_s2", "gx_rad_s", "gy_rad_s", "gz_rad_s"))
        for t, row in zip(times.tolist(), rows.tolist(), strict=True):
            out.writerow((f"{t:.9g}", *(f"{number:.{digits}g}" if digits else repr(number) for number in row)))


def random_scene(rng: np.random.Generator) -> dict:
    """Draw a scene with a tumbling box and an IMU away from its centre of mass."""
    body = {
        "shape": "box",
        "size": rng.uniform(0.1, 0.6, 3).tolist(),
        "mass": float(rng.uniform(0.2, 5.0)),
        "orientation": rng.standard_normal(4).tolist(),
        "velocity": (2.0 * rng.standard_normal(3)).tolist(),
        "angular_velocity": (3.0 * rng.standard_normal(3)).tolist(),
    }
    scene = {"title": "Random IMU", "duration": 2.0, "samples": 10, "step": 0.001, "body": body}
    if rng.random() < 0.8:
        down = rng.standard_normal(3) if rng.random() < 0.3 else np.array([0.0, -1.0, 0.0])
        scene["gravity"] = (9.81 * down / np.linalg.norm(down)).tolist()
    if rng.random() < 0.5:
        scene["drag"] = {"linear": float(rng.uniform(0.1, 2.0)), "angular": float(rng.uniform(0.0, 0.02))}
    if rng.random() < 0.4:
        point = (rng.uniform(-0.5, 0.5, 3) * body["size"]).tolist()
        push = (body["mass"] * rng.standard_normal(3)).tolist()
        scene["impulse"] = [{"time": float(rng.uniform(0.2, 1.5)), "value": push, "point_body": point}]
    sensor = {"name": "imu", "kind": "imu", "rate": 100.0, "point": rng.uniform(-0.3, 0.3, 3).tolist()}
    if rng.random() < 0.5:
        sensor["orientation"] = rng.standard_normal(4).tolist()
    return scene | {"sensor": [sensor]}


def random_times(rng: np.random.Generator, scene: dict) -> np.ndarray:
    """Draw the rows of a file: 100 to 500 Hz over the scene."""
    rate = float(rng.choice([100.0, 125.0, 200.0, 250.0]))
    return np.arange(round(scene["duration"] * rate) + 1) / rate


def toml(scene: dict) -> str:
    """Return a scene as TOML."""
    lines, tables = [], []
    for key, value in scene.items():
        if isinstance(value, dict):
            tables += [f"[{key}]", *_lines(value)]
        elif isinstance(value, list) and isinstance(value[0], dict):
            for table in value:
                tables += [f"[[{key}]]", *_lines(table)]
        else:
            lines += _lines({key: value})
    return "\n".join([*lines, *tables]) + "\n"


def _lines(table: dict) -> list:
    return [f'{key} = "{value}"' if isinstance(value, str) else f"{key} = {value!r}" for key, value in table.items()]


def combined(*names: str) -> Imu:
    """Return a program with these mistakes."""
    known = {each.name for each in fields(Imu)}
    wrong = {key: value for name in names for key, value in MISTAKES[name].items()}
    assert set(wrong) <= known
    return Imu(**wrong)


def bug_reports(scene: dict, times: np.ndarray) -> dict:
    """Return what three programs read: isaac-sim/IsaacSim issues 735 and 825, RocketPy-Team/RocketPy PR 1175."""
    rocketpy = readings(scene, Motion(scene), times, Imu(gravity=-1.0), np.random.default_rng(0))
    return {
        "isaacsim-735": isaacsim(scene, times, of_point=True, in_body_axes=True),
        "isaacsim-825": isaacsim(scene, times, of_point=False, in_body_axes=False),
        "rocketpy-1175": rocketpy,
    }


def isaacsim(scene: dict, times: np.ndarray, of_point: bool, in_body_axes: bool) -> np.ndarray:
    """Return readings as IsaacSim made them: the velocities of two physics steps are differenced.

    in_body_axes: their components are (issue 735); of_point: of the sensor's point, not of the centre (issue 825).
    """
    motion, mount = Motion(scene), rotation(scene["sensor"][0].get("orientation", (1, 0, 0, 0)))
    point, rows, last = np.array(scene["sensor"][0]["point"]), [], None
    for t in times:
        turn, v, _, w, _ = motion.at(t)
        velocity = v + np.cross(w, turn @ point) * of_point
        velocity = turn.T @ velocity if in_body_axes else velocity
        rate = (velocity - last) / (times[1] - times[0]) if last is not None else np.zeros(3)
        last = velocity
        acceleration = rate if in_body_axes else turn.T @ rate
        rows.append(np.concatenate((mount.T @ (acceleration - turn.T @ motion.gravity), mount.T @ turn.T @ w)))
    return np.array(rows)
