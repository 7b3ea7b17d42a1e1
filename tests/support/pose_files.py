"""Files of poses, and a scene of a body whose principal axes are not those of its file."""

from pathlib import Path

import numpy as np

# Products of inertia turn the principal axes.
POINTS = "[[0.3, 0, 0], [-0.3, 0, 0.1], [0, 0.2, 0], [0, -0.2, 0.1], [0, 0, 0.2]]"
SKEWED = f"""
title = "Skewed body in the air"
duration = 1.0
samples = 25
step = 0.001
[body]
shape = "rigid"
mass = 1.7
inertia = [[0.03, 0.004, -0.002], [0.004, 0.04, 0.003], [-0.002, 0.003, 0.05]]
points = {POINTS}
position = [0.2, 1.0, -0.4]
orientation = [0.9, 0.1, -0.3, 0.3]
velocity = [0.4, 2.0, -0.7]
angular_velocity = [1.0, 2.0, -0.5]
"""


def write_poses(path: Path, times, *poses, form: str = "%.12g") -> Path:
    """Write a file of times [s], (T,), with centres [m] and quaternions, (T, 3) and (T, 4) or together; return it."""
    header = "t_s,x_m,y_m,z_m,qw,qx,qy,qz"
    np.savetxt(path, np.column_stack((times, *poses)), form, ",", header=header, comments="", encoding="utf-8")
    return path
