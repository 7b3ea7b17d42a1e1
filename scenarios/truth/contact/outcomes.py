"""Where several points meet the plane at once the law has several answers: the set of them, and what is inside.

One impact at a time, in any order, gives each another motion (Uchida, Sherman & Delp, "Making a meaningful impact:
modelling simultaneous frictional collisions in spatial multibody systems", Proc. R. Soc. A 471 (2015) 20140859); all at
once gives Moreau's.  Inside the set is what impulses can do that push, lie within the friction cone, leave no point
approaching, and lose an amount of energy between the least and the greatest that any of these outcomes loses.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.truth.contact.impact import impact, velocity_at
from tumble.scenarios.truth.contact.setting import Setting
from tumble.scenarios.truth.flight import Pose

# Orders of single impacts are followed as long as this, and as many of them, at most.
LONGEST_ORDER, MOST_ORDERS = 24, 256
# Of the approach: a point that approaches more slowly does so by rounding.
STILL = 1e-9
# The edges of the pyramid that stands for the friction cone, which it fills to 0.1 %.
EDGES = 64


@dataclass(frozen=True, eq=False)
class OutcomeSet:
    """The set of velocities after several impacts at once.

    time_s; points: which touch; before: (6,), v [m/s] and w [rad/s], world; arms: of the points, (k, 3), world [m];
    symmetric: (6,), all at once; extremes: (n, 6), after the orders of single impacts that end; energy_lost: least and
    greatest of these [J], (2,).
    """

    points: tuple[int, ...]
    before: Array
    symmetric: Array
    extremes: Array
    energy_lost: Array
    _arms: Array
    _normal: Array
    _inverse: Array  # of mass and inertia, (6, 6)
    _friction: float

    def is_in_set(self, v: Array, w: Array, tolerance: float = 1e-6) -> bool:
        """Return whether velocities after the impacts, (3,) and (3,), world, are an answer that the law allows.

        tolerance: of the speed before the impacts.
        """
        from scipy.optimize import nnls  # a verdict pays for it, not every truth

        after = np.concatenate((v, w))
        scale = np.sqrt(self.before @ np.linalg.solve(self._inverse, self.before))
        rates = after[:3] + np.cross(after[3:], self._arms)
        speed = np.linalg.norm(self.before[:3] + np.cross(self.before[3:], self._arms), axis=1).max()
        if (rates @ self._normal < -tolerance * speed).any():
            return False
        lost = self._energy(self.before) - self._energy(after)
        allowed = tolerance * self._energy(self.before)
        if not self.energy_lost[0] - allowed <= lost <= self.energy_lost[1] + allowed:
            return False
        half = np.linalg.cholesky(np.linalg.inv(self._inverse)).T
        pushes = half @ self._inverse @ self._pushes().T
        return bool(nnls(pushes, half @ (after - self.before))[1] <= tolerance * scale)

    def _pushes(self) -> Array:
        """Return impulses and their torques along the edges of every point's friction cone, (k EDGES, 6)."""
        normal = self._normal
        first = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
        first /= np.linalg.norm(first)
        angles = 2 * np.pi * np.arange(EDGES if self._friction else 1) / EDGES
        around = np.outer(np.cos(angles), first) + np.outer(np.sin(angles), np.cross(normal, first))
        forces = normal + self._friction * around / np.cos(np.pi / EDGES)
        return np.concatenate([np.hstack((forces, np.cross(arm, forces))) for arm in self._arms])

    def _energy(self, velocity: Array) -> float:
        return float(velocity @ np.linalg.solve(self._inverse, velocity)) / 2


def outcome_set(setting: Setting, points: tuple[int, ...], pose: Pose) -> OutcomeSet:
    """Return the set of outcomes where points of a pose meet the plane at once."""
    arms = setting.levers(pose)[list(points)]
    orders = _orders(setting, pose, arms)
    inverse = np.zeros((6, 6))
    inverse[:3, :3] = np.eye(3) / float(setting.mass)
    inverse[3:, 3:] = setting.inverse_world(pose).astype(float)
    before, normal = _velocity(pose), setting.normal.astype(float)
    found = OutcomeSet(
        points, before, before, before[None], np.zeros(2), arms.astype(float), normal, inverse, float(setting.friction)
    )
    symmetric = _together(setting, found)
    extremes = np.array([_velocity(order) for order in orders]).reshape(-1, 6)
    lost = [found._energy(before) - found._energy(after) for after in (symmetric, *extremes)]
    return OutcomeSet(
        points,
        before,
        symmetric,
        extremes,
        np.array((min(lost), max(lost))),
        found._arms,
        normal,
        inverse,
        found._friction,
    )


def _velocity(pose: Pose) -> Array:
    return np.concatenate((pose.v, pose.w_world)).astype(float)


def _orders(setting: Setting, pose: Pose, arms: Array) -> list[Pose]:
    """Return the poses after every order of single impacts that ends."""
    fastest = max(abs(float(velocity_at(pose, arm) @ setting.normal)) for arm in arms)
    open_orders, ended = [(pose, 0)], []
    while open_orders and len(ended) < MOST_ORDERS:
        now, count = open_orders.pop()
        meets = [arm for arm in arms if float(velocity_at(now, arm) @ setting.normal) < -STILL * fastest]
        if not meets:
            ended.append(now)
        elif count < LONGEST_ORDER:
            open_orders += [(impact(setting, now, arm).pose, count + 1) for arm in meets]
        if len(open_orders) > MOST_ORDERS:
            del open_orders[:-MOST_ORDERS]
    return ended


def _together(setting: Setting, found: OutcomeSet) -> Array:
    """Return the velocity after all impacts at once: Moreau's law, u_n >= -e u_n(0), by projected Gauss-Seidel steps.

    Source: Moreau, "Unilateral contact and dry friction in finite freedom dynamics" (1988); the least impulses are
    found where several do, so what is symmetric stays so.
    """
    from scipy.optimize import nnls

    normal, e, mu = found._normal, float(setting.restitution), found._friction
    arms, before, inverse = found._arms, found.before, found._inverse
    rows = np.array([np.concatenate((normal, np.cross(arm, normal))) for arm in arms])
    target = np.array([-e * min(float(row @ before), 0.0) for row in rows])
    half = np.linalg.cholesky(inverse).T
    # Without friction: min |J|_K^2 / 2 + J (u + e u) over J >= 0, as a non-negative least squares problem.
    wanted = target - rows @ before
    system = half @ rows.T
    weight = np.vstack((system, 1e-9 * np.abs(system).max() * np.eye(len(arms))))
    goal = np.linalg.lstsq(weight.T, wanted, rcond=None)[0]
    impulses = nnls(weight, goal)[0]
    after = before + inverse @ rows.T @ impulses
    if mu:
        after = _with_friction(after, found, impulses)
    return after


def _with_friction(after: Array, found: OutcomeSet, impulses: Array) -> Array:
    """Return the velocity with friction of the normal impulses, sticking where the cone allows it, by iteration."""
    normal, inverse, along = found._normal, found._inverse, np.eye(3) - np.outer(found._normal, found._normal)
    friction = np.zeros((len(found._arms), 3))
    jacobians = [np.hstack((along, -along @ _skew(arm))) for arm in found._arms]
    for _ in range(400):
        for number, jacobian in enumerate(jacobians):
            slip = jacobian @ after
            size = float(np.trace(jacobian @ inverse @ jacobian.T)) / 2
            wished = friction[number] - slip / size
            most = found._friction * impulses[number]
            length = float(np.linalg.norm(wished))
            allowed = wished if length <= most else wished * most / length
            after = after + inverse @ jacobian.T @ (allowed - friction[number])
            friction[number] = allowed
    del normal
    return after


def _skew(arm: Array) -> Any:
    x, y, z = arm
    return np.array(((0, -z, y), (z, 0, -x), (-y, x, 0)))
