"""A flight above a rigid plane: many throws of one body, each by one contact method."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tumble.solver.body import Body
from tumble.solver.contact.ground import Ground
from tumble.solver.quaternion import from_matrix, to_matrix, turned

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Plane:
    """A rigid plane, and of the body what can touch it.

    Parameters
    ----------
    point : (3,), m
        world axes
    normal : (3,)
        unit vector towards the body's side, world axes
    restitution : Newton's, of the pair
    friction : Coulomb's, of the pair
    points : (n, 3), m
        of the body, body axes
    radius : m
        of a sphere, else 0
    disc : m
        radius and thickness of a disc about the body's third axis, else None
    """

    point: Array
    normal: Array
    restitution: float
    friction: float
    points: Array
    radius: float = 0.0
    disc: tuple[float, float] | None = None


def axes_of(normal: ArrayLike) -> Array:
    """Return the frame of a plane.

    Parameters
    ----------
    normal : (3,)

    Returns
    -------
    unit vectors along the plane and along its normal as rows, (3, 3), right-handed
    """
    n = np.asarray(normal, dtype=float)
    # Exact where the normal is an axis: the plane's first two axes are then axes of the world.
    first = np.roll(np.eye(3)[int(np.argmax(np.abs(n)))], 1)
    first = first - n * (n @ first)
    first /= np.linalg.norm(first)
    return np.array((first, np.cross(n, first), n))


class ContactFlight:
    """N throws of one body above a plane, by one method; without a plane, in free flight by the same.

    Parameters
    ----------
    body
    method
        a name of `tumble.solver.contact.methods`
    gravity : (3,), m/s2
        world axes; None if there is none
    plane
        None if there is none

    Raises
    ------
    ValueError
        The method does not exist.
    """

    def __init__(self, body: Body, method: str, gravity: ArrayLike | None, plane: Plane | None) -> None:
        from tumble.solver.contact.methods import find  # slow to load, and only a flight needs them

        self.method = find(method)
        self._body = body
        normal = np.array((0.0, 0.0, 1.0)) if plane is None else np.asarray(plane.normal, dtype=float)
        self._axes = axes_of(normal)
        self._origin = np.zeros(3) if plane is None else np.asarray(plane.point, dtype=float)
        self._turn = _left(from_matrix(self._axes))
        self.ground = ground_of(body, self._axes, gravity, plane)
        self.write(np.empty((0, 13)))

    def write(self, states: ArrayLike) -> None:
        """Start from these states, (N, 13), and forget all that was before.  Raises ValueError for another shape."""
        start = np.asarray(states, dtype=float)
        if start.ndim != 2 or start.shape[1] != 13:
            raise ValueError(f"states must have the shape (N, 13), got {start.shape}")
        q = start[:, 3:7] / np.sqrt(np.sum(start[:, 3:7] ** 2, axis=1, keepdims=True))
        w_body = turned(np.swapaxes(to_matrix(q), -2, -1), start[:, 10:13])
        self.rows = np.zeros((len(start), self.method.width(self.ground)))
        self.rows[:, 0:3] = turned(self._axes, start[:, 0:3] - self._origin)
        self.rows[:, 3:7] = turned(self._turn, q)
        self.rows[:, 7:10] = turned(self._axes, start[:, 7:10])
        self.rows[:, 10:13] = np.array(self._body.moments) * w_body
        self.rows[:, 13:26] = self.rows[:, 0:13]
        self._begun, self._steps, self.dt = 0.0, 0, 0.0

    def advance(self, n: int, dt: float) -> None:
        """Take n steps of dt [s].  Two advances of one dt are one long one to the last bit."""
        if dt != self.dt:
            self._begun, self._steps, self.dt = self._begun + self._steps * self.dt, 0, float(dt)
        self._steps += int(n)
        if self.method.dense:
            self.method.steps(self.rows, self._begun + self._steps * self.dt, self.ground)
        else:
            self.method.steps(self.rows, int(n), self.dt, self.ground)

    def read(self) -> Array:
        """Return the states, (N, 13)."""
        states = np.empty((len(self.rows), 13))
        q = self.rows[:, 3:7] / np.sqrt(np.sum(self.rows[:, 3:7] ** 2, axis=1, keepdims=True))
        w = turned(to_matrix(q), self.rows[:, 10:13] / np.array(self._body.moments))
        states[:, 0:3] = self._origin + turned(self._axes.T, self.rows[:, 0:3])
        states[:, 3:7] = turned(self._turn.T, q)
        states[:, 7:10] = turned(self._axes.T, self.rows[:, 7:10])
        states[:, 10:13] = turned(self._axes.T, w)
        return states

    @property
    def findings(self) -> list[str]:
        """What the states do not show: why a motion is not known to its end."""
        return self.method.findings(self.rows)

    @property
    def remark(self) -> str:
        """What the law leaves open or allows and happened: several points struck at once, an impact gained energy."""
        said = []
        if times := self.method.at_once(self.rows):
            said.append(
                f"several points hit the plane at once {times:.0f} times: of the law's answers the symmetric one"
            )
        if (gained := self.method.gained(self.rows)) > 0.0:
            said.append(f"impacts gained {gained:.3g} J, as Newton's restitution with friction can (Kane and Levinson)")
        return "; ".join(said)

    def compile(self) -> None:
        """Compile the method's kernel."""
        nothing: Any = (0.0,) if self.method.dense else (0, 0.0)
        self.method.steps(self.rows[:0], *nothing, self.ground)


def ground_of(body: Body, axes: Array, gravity: ArrayLike | None, plane: Plane | None) -> Ground:
    """Return plane and body in the plane's frame; without a plane no point of the body can touch anything."""
    pull = np.zeros(3) if gravity is None else turned(axes, np.asarray(gravity, dtype=float))
    radius = 0.0 if plane is None else float(plane.radius)
    rim, thickness = (plane and plane.disc) or (0.0, 0.0)
    points = np.empty((0, 3)) if plane is None or radius or rim else np.array(plane.points, dtype=float)
    furthest = float(np.linalg.norm(points, axis=1).max()) if len(points) else 1.0
    reach = radius or (float(np.hypot(rim, thickness / 2)) if rim else furthest)
    return Ground(
        restitution=0.0 if plane is None else float(plane.restitution),
        friction=0.0 if plane is None else float(plane.friction),
        gravity=(float(pull[0]), float(pull[1]), float(pull[2])),
        mass=float(body.mass),
        moments=body.moments,
        inverse_moments=body.inverse_moments,
        gyroscopic=body.gyroscopic or (0.0, 0.0, 0.0),
        points=points,
        radius=radius,
        rim=float(rim),
        half=float(thickness) / 2,
        reach=reach,
        far=0.0 if plane is None else float(np.abs(plane.point).max()),
    )


def _left(p: Array) -> Array:
    """Return the matrix of the product with a unit quaternion from the left, (4, 4); its transpose undoes it."""
    w, x, y, z = p
    return np.array(((w, -x, -y, -z), (x, w, -z, y), (y, z, w, -x), (z, -y, x, w)))
