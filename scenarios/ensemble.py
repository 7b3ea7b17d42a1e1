"""Many throws of one body: the start as written, then starts drawn around it.

Every spread has a stream of random numbers of its own, so that widening one leaves the others' draws as they were.
The impulses of t = 0 differ from throw to throw, so they are given here: the starts are those after them.

Throws that are too many to be held at once are drawn in blocks, each with streams of its own: any part of them can be
drawn alone, and more of them leave the first as they were.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tumble.scenarios.frames import Array, quaternion_product, rotation_matrix
from tumble.scenarios.impulse import RayMissed, strike_point
from tumble.scenarios.scene import Body, Ensemble, Impulse, Scene, frozen_array

# Throws times faces that are held against each other at a time: what stays below 100 MB.
AT_A_TIME = 500_000
# Throws of a block, and the most whose starts are ever held together.
BLOCK, MOST_TOGETHER = 2**14, 1_000_000
# More throws than this, or trajectories of more bytes, are run in parts.
TOGETHER, MOST_BYTES = 100_000, 2**30
# Bytes of a part's reference solution; and its throws where each of them is integrated, or has an impulse on its way.
PART_BYTES, SLOW_PART = 2**25, 64
# Rounds of rejection without a point kept, where one in eight is kept at a corner of a box.
ROUNDS = 1000


class OutOfReach(ValueError):
    """No part of the surface is as near to where an impulse lands as its spot may be."""


def throws(
    start: Array,
    impulses: Sequence[Impulse],
    body: Body,
    n: int,
    seed: int = 0,
    magnitude: float = 0.0,
    cone: float = 0.0,
    point: float = 0.0,
    orientation: float = 0.0,
    block: int = 0,
) -> Array:
    """Return n starts, (n, 13), after the impulses, all of which act at t = 0, one after the other.

    start: as written, (1, 13).  Throw 0 is the one as written.  The others are drawn uniformly and independently:
    magnitude: the impulse's size, within this share of it, at most 1;
    cone: its direction, on the cap of the sphere within this angle of it [rad];
    point: where it lands, on the surface within this distance of where it lands as written [m]; in the ball of that
    radius where the body has no surface;
    orientation: a turn of the body about its centre before the impulses, by an angle up to this [rad], its axis on the
    sphere; velocities, rays and points in world axes do not turn with it.
    block: number of the block whose throws these are; only that of number 0 has the throw as written.
    Raises RayMissed or OutOfReach, whose text names the throw.
    """
    states, of_block = np.repeat(start, n, axis=0), (block,) if block else ()
    drawn = slice(0 if block else 1, n)
    count = len(states[drawn])
    if orientation:
        turns = _turns(_stream(seed, 0, *of_block), count, orientation)
        states[drawn, 3:7] = quaternion_product(turns, states[drawn, 3:7])
    for number, impulse in enumerate(impulses):
        streams = [_stream(seed, 1 + number, spread, *of_block) for spread in range(3)]
        values = np.repeat(impulse.value[None], n, axis=0)
        if cone:
            values[drawn] = _tilted(streams[0], impulse.value, count, cone)
        if magnitude:
            values[drawn] *= streams[1].uniform(1 - magnitude, 1 + magnitude, (count, 1))
        spots = _spots(impulse, states, body)
        if point:
            spots[drawn] = _moved(streams[2], spots[drawn], body, point)
        states = _applied(states, values, spots, body)
    return states


def starts(ensemble: Ensemble, body: Body, first: int, last: int) -> Array:
    """Return the starts of some throws of a large ensemble.

    Parameters
    ----------
    ensemble
    body
    first, last
        numbers of the first throw and of the one after the last

    Returns
    -------
    states : (last - first, 13)
        after the impulses of t = 0

    Raises
    ------
    RayMissed, OutOfReach
        as `throws`
    """
    spreads = ensemble.seed, ensemble.magnitude, ensemble.cone, ensemble.point, ensemble.orientation
    found = []
    for block in range(first // BLOCK, -(-last // BLOCK)):
        begin = block * BLOCK
        drawn = throws(ensemble.start, ensemble.impulses, body, BLOCK, *spreads, block)
        found.append(drawn[max(first - begin, 0) : last - begin])
    return np.concatenate(found)


def part_size(scene: Scene) -> int:
    """Return the number of throws of a part of a large ensemble, a power of two of at most BLOCK.

    Parameters
    ----------
    scene

    Returns
    -------
    number
    """
    if not scene.is_free or scene.impulses:
        return SLOW_PART
    return max(1, min(BLOCK, 2 ** int(np.log2(PART_BYTES / throw_bytes(len(scene.rows), scene.body)))))


def is_large(count: int, rows: int, body: Body) -> bool:
    """Return whether this many throws are run in parts.

    Parameters
    ----------
    count
        of throws
    rows
        instants of a trajectory
    body

    Returns
    -------
    bool
    """
    return count > TOGETHER or count * throw_bytes(rows, body) > MOST_BYTES


def throw_bytes(rows: int, body: Body) -> int:
    """Return the size of one throw's reference solution [B], with that many instants."""
    return 8 * rows * (13 + body.points.size + 2)


def parts_in(scene: Scene) -> int:
    """Return the number of parts of a scene, 0 of one whose throws are all held at once.

    Parameters
    ----------
    scene

    Returns
    -------
    number
    """
    return 0 if scene.ensemble is None else max(1, scene.ensemble.throws // part_size(scene))


def part_of(scene: Scene, part: int) -> Scene:
    """Return a part of a large ensemble, as a scene that has its throws.

    Parameters
    ----------
    scene
        has an ensemble
    part
        number of the part, from 0 on

    Returns
    -------
    scene
    """
    assert scene.ensemble is not None
    # The last has what is left besides: some methods are for many throws alone.
    first = part * part_size(scene)
    last = first + part_size(scene) if part < parts_in(scene) - 1 else scene.ensemble.throws
    return replace(scene, start=frozen_array(starts(scene.ensemble, scene.body, first, last)), ensemble=None)


def _stream(seed: int, *purpose: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=purpose)))


def _sphere(stream: np.random.Generator, n: int) -> Array:
    """Return n unit vectors, (n, 3), uniform on the sphere: Archimedes, equal heights bound equal areas."""
    return _cap(stream, n, np.pi)


def _cap(stream: np.random.Generator, n: int, cone: float) -> Array:
    """Return n unit vectors, (n, 3), uniform on the sphere within an angle [rad] of (0, 0, 1)."""
    share, azimuth = stream.random((n, 2)).T
    depth = share * 2 * np.sin(cone / 2) ** 2  # 1 - cos, which for a narrow cone would lose its digits
    across = np.sqrt(depth * (2 - depth))
    return np.stack((across * np.cos(2 * np.pi * azimuth), across * np.sin(2 * np.pi * azimuth), 1 - depth), axis=1)


def _turns(stream: np.random.Generator, n: int, largest: float) -> Array:
    """Return n quaternions, (n, 4), of turns by 0 ... largest [rad], uniform, about an axis uniform on the sphere."""
    axes = _sphere(stream, n)
    half = stream.uniform(0, largest / 2, (n, 1))
    return np.hstack((np.cos(half), np.sin(half) * axes))


def _tilted(stream: np.random.Generator, impulse: Array, n: int, cone: float) -> Array:
    """Return n vectors, (n, 3), of the length of one that is not zero, (3,), uniform on the cap about it."""
    size = float(np.linalg.norm(impulse))
    pole = impulse / size
    side = np.cross(pole, np.eye(3)[np.argmin(np.abs(pole))])
    side /= np.linalg.norm(side)
    axes: Array = np.array((side, np.cross(pole, side), pole), dtype=float)
    return size * _cap(stream, n, cone) @ axes


def _spots(impulse: Impulse, states: Array, body: Body) -> Array:
    """Return where the impulse lands as written, (N, 3), body axes [m].  Raises RayMissed."""
    if impulse.point_body is not None:
        return np.repeat(impulse.point_body[None], len(states), axis=0)
    axes = rotation_matrix(states[:, 3:7])
    if impulse.point_world is not None:
        return np.einsum("nji,nj->ni", axes, impulse.point_world - states[:, 0:3])
    turned_alike = (states[:, 3:7] == states[0, 3:7]).all()
    landed = np.empty((len(states), 3))
    for throw, state in enumerate(states[:1] if turned_alike else states):
        try:
            landed[throw] = axes[throw].T @ (strike_point(impulse, state, body) - state[0:3])
        except RayMissed as missed:
            raise RayMissed(f"throw {throw}: {missed}") from None
    return np.repeat(landed[:1], len(states), axis=0) if turned_alike else landed


def _moved(stream: np.random.Generator, spots: Array, body: Body, reach: float) -> Array:
    """Return a point near each spot, (n, 3), body axes [m].  Raises OutOfReach."""
    if not len(body.faces):
        return spots + reach * np.cbrt(stream.random((len(spots), 1))) * _sphere(stream, len(spots))
    corners = body.points[body.faces]
    some = max(1, AT_A_TIME // len(corners))
    parts = range(0, len(spots), some)
    return np.concatenate([_on_surface(stream, spots[i : i + some], corners, reach, 1 + i) for i in parts] or [spots])


def _on_surface(stream: np.random.Generator, spots: Array, corners: Array, reach: float, first: int) -> Array:
    """Return points uniform on triangles (m, 3, 3) within reach of each spot, (n, 3); first: the number of its throw.

    By rejection: a triangle is drawn by the smaller of two areas, of the disc that the ball cuts out of its plane and
    of the parallelogram it is half of, then a point of that one, kept where it is of the ball and of the triangle.
    """
    origins, edges, others = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    crossed = np.cross(edges, others)
    areas = np.linalg.norm(crossed, axis=1)  # of the parallelograms
    normals = crossed / areas[:, None]
    tangents = edges / np.linalg.norm(edges, axis=1)[:, None]
    bitangents = np.cross(normals, tangents)
    middles = corners.mean(axis=1)
    radii = np.linalg.norm(corners - middles[:, None], axis=2).max(axis=1)
    near = np.linalg.norm(spots[:, None] - middles, axis=2) <= reach + radii
    heights = spots @ normals.T - np.einsum("mi,mi->m", origins, normals)
    discs = near * np.pi * np.maximum(reach * reach - heights * heights, 0)
    heaped = np.cumsum(np.minimum(discs, areas), axis=1)

    drawn, waiting = np.empty_like(spots), np.arange(len(spots))
    for _ in range(ROUNDS):
        pick, u, v = stream.random((len(waiting), 3)).T
        face = np.minimum((heaped[waiting] <= (pick * heaped[waiting, -1])[:, None]).sum(axis=1), len(corners) - 1)
        disc, foot = discs[waiting, face], spots[waiting] - heights[waiting, face][:, None] * normals[face]
        radius, azimuth = np.sqrt(u * disc / np.pi)[:, None], (2 * np.pi * v)[:, None]
        on_disc = foot + radius * (np.cos(azimuth) * tangents[face] + np.sin(azimuth) * bitangents[face])
        on_face = origins[face] + u[:, None] * edges[face] + v[:, None] * others[face]
        smaller = disc < areas[face]
        point = np.where(smaller[:, None], on_disc, on_face)
        offset = point - origins[face]
        along = np.einsum("ni,ni->n", np.cross(offset, others[face]), normals[face])
        across = np.einsum("ni,ni->n", np.cross(edges[face], offset), normals[face])
        inside = (along >= 0) & (across >= 0) & (along + across <= areas[face])
        within = np.linalg.norm(point - spots[waiting], axis=1) <= reach
        accepted = inside & within
        drawn[waiting[accepted]] = point[accepted]
        waiting = waiting[~accepted]
        if not len(waiting):
            return drawn
    throw = first + int(waiting[0])
    raise OutOfReach(f"throw {throw}: no surface within {reach:g} m of where the impulse lands")


def _applied(states: Array, values: Array, spots: Array, body: Body) -> Array:
    """Return the states after each throw's own impulse: as `tumble.scenarios.impulse.jump`, in body axes.

    values: impulses, (N, 3), world axes [N s]; spots: (N, 3), body axes [m].
    """
    axes = rotation_matrix(states[:, 3:7])
    impulses_body = np.einsum("nji,nj->ni", axes, values)
    after = states.copy()
    after[:, 7:10] += values / body.mass
    after[:, 10:13] += np.einsum("nij,nj->ni", axes, np.cross(spots, impulses_body) / body.moments)
    return after
