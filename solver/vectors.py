"""Vectors of three numbers, as tuples."""

from tumble.solver.compilation import scalar

Vector = tuple[float, float, float]


@scalar
def add(a: Vector, b: Vector) -> Vector:
    """Return a + b.

    Parameters
    ----------
    a, b : (3,)

    Returns
    -------
    sum : (3,)
    """
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@scalar
def scale(factor: float, a: Vector) -> Vector:
    """Return factor a.

    Parameters
    ----------
    factor
    a : (3,)

    Returns
    -------
    product : (3,)
    """
    return (factor * a[0], factor * a[1], factor * a[2])


@scalar
def times(diagonal: Vector, a: Vector) -> Vector:
    """Return diag(diagonal) a, the product with a tensor in its principal axes.

    Parameters
    ----------
    diagonal : (3,)
        the tensor's diagonal
    a : (3,)

    Returns
    -------
    product : (3,)
    """
    return (diagonal[0] * a[0], diagonal[1] * a[1], diagonal[2] * a[2])


@scalar
def dot(a: Vector, b: Vector) -> float:
    """Return a . b.

    Parameters
    ----------
    a, b : (3,)

    Returns
    -------
    product
    """
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@scalar
def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b.

    Parameters
    ----------
    a, b : (3,)

    Returns
    -------
    product : (3,)
    """
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
