"""What is the user's to mend: an error whose text is the one line to show, and whose exit code is 2."""

from collections.abc import Sequence


class UserError(ValueError):
    """Something of the user's that cannot be used: a scene, an engine, a step, a ray, a record, a trajectory."""


def nearest(name: str, known: Sequence[str]) -> str:
    """Return a suggestion for a misspelt name: the nearest of the known names, or all of them.

    Parameters
    ----------
    name
    known

    Returns
    -------
    suggestion
    """
    import difflib  # only a mistake pays for it

    near = difflib.get_close_matches(name, known, n=1)
    return f"did you mean {near[0]!r}?" if near else f"there are {', '.join(known)}"
