"""What is the user's to mend: an error whose text is the one line to show, and whose exit code is 2."""


class UsersError(ValueError):
    """Something of the user's that cannot be used: a scene, an engine, a step, a ray, a record, a trajectory."""
