"""One number of a scene changed, step by step, where the truth stays known: tilt of the plane, height of the drop.

Each run is at the step at which values are reported.  The directions of a slide are another scan, with laws of their
own: `directions`.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from tumble.compare.contact.asked import CREEP
from tumble.compare.contact.directions import reaches_edge
from tumble.compare.contact.impacts import (
    PHASES,
    REBOUND,
    Impact,
    ImpactRun,
    read_impact,
    row_step,
    run_scene,
    sample_times,
)
from tumble.compare.contact.watched import Watched, gravity
from tumble.compare.contact.whole_run import WholeRun
from tumble.scenarios.scene import Scene

# Tangents of the tilt over friction: below 1 the body holds, above it slides.
TILTS = (0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.01, 1.05, 1.2)
# Speeds of approach over the scene's own; a drop's height is their square.
SPEEDS = (0.125, 0.25, 0.5, 1.0, 2.0)
TILT, HEIGHT = "tilt", "drop height"


@dataclass(frozen=True, eq=False)
class ScanRun:
    """One run: of which scan, at which number, what is observed, its true value, and what reads it."""

    scan: str
    at: float
    at_unit: str
    observable: str
    true: float
    unit: str
    scene: Scene
    read: Callable[[Watched], float]


def tilts(scene: Scene, whole: WholeRun, dt: float) -> Iterator[ScanRun]:
    """Yield tilts of the plane under a body that rests on a face of it, by turning gravity; dt: the step [s]."""
    plane, pull = scene.plane, gravity(scene)
    assert plane is not None
    rests = CREEP in whole.asked and whole.asked[CREEP][1].begins_s == 0
    down = pull - (pull @ plane.normal) * plane.normal
    slope, size = float(np.linalg.norm(down)), float(np.linalg.norm(pull))
    if not rests or not plane.friction or slope <= 1e-9 * size or scene.impulses or scene.body.radius is not None:
        return
    if reaches_edge(scene) <= TILTS[-1] * plane.friction:
        return
    for ratio in TILTS:
        angle = math.atan(ratio * plane.friction)
        turned = size * (math.sin(angle) * down / slope - math.cos(angle) * plane.normal)
        took = scene.duration
        true = max(0.0, size * (math.sin(angle) - plane.friction * math.cos(angle)) * took)
        own = replace(scene, gravity=turned, times=np.array([took]), step=dt, written=None)
        yield ScanRun(TILT, ratio, "1", "speed along the plane at the end", true, "m/s", own, end_speed)


def end_speed(seen: Watched) -> float:
    """Return the speed along the plane at the end [m/s]."""
    return float(np.linalg.norm(seen.along(seen.states[-1, 7:10])))


def heights(scene: Scene, impact: Impact, step: float) -> Iterator[ScanRun]:
    """Yield drops of a ball that does not spin, without friction, from other heights, by its speed of approach."""
    plane, dt = scene.plane, row_step(impact, step)
    assert plane is not None
    before, pull = impact.event.before, gravity(scene)
    weight, up = -float(pull @ plane.normal), float(before[7:10] @ plane.normal)
    straight = np.allclose(before[7:10], up * plane.normal, rtol=0, atol=1e-12 * abs(up))
    if scene.body.radius is None or not straight or before[10:13].any() or weight <= 0 or not plane.restitution:
        return
    for factor in SPEEDS:
        speed = -factor * up
        for phase in PHASES:
            lead = (2 + phase) * dt
            follow = 1.2 * plane.restitution * speed / weight
            start = before.copy()
            start[7:10] = -(speed - weight * lead) * plane.normal
            start[0:3] += (speed * lead - weight * lead**2 / 2) * plane.normal
            run = ImpactRun(run_scene(scene, start, sample_times(lead, follow, dt), dt), lead, before)
            own = replace(impact, event=replace(impact.event, before=at_speed(before, speed, plane.normal)))
            yield ScanRun(
                scan=HEIGHT,
                at=speed**2 / (2 * weight),
                at_unit="m",
                observable=f"restitution, the plane met at {phase:g} of a step",
                true=plane.restitution,
                unit="1",
                scene=run.scene,
                read=restitution(own, run, speed),
            )


def at_speed(state: np.ndarray, speed: float, normal: np.ndarray) -> np.ndarray:
    """Return a state that falls towards the plane with a speed [m/s], (13,)."""
    state = state.copy()
    state[7:10] = -speed * normal
    return state


def restitution(impact: Impact, run: ImpactRun, speed: float) -> Callable[[Watched], float]:
    """Return what reads the ratio of the speeds after and before an impact."""
    return partial(speed_ratio, impact, run, speed)


def speed_ratio(impact: Impact, run: ImpactRun, speed: float, seen: Watched) -> float:
    """Return the ratio of the speeds after and before an impact, nan where the body did not leave the plane."""
    return read_impact(impact, run, seen).values.get(REBOUND, math.nan) / speed
