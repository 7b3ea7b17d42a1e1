"""The motion of a program, right or wrong, as a sensor on its body would measure it."""

import numpy as np

from tumble.compare.grade.model.kinematics import Kinematics, in_axes
from tumble.compare.grade.model.program_model import FINE, ProgramModel
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene
from tumble.scenarios.wrench import wrench


class ProgramMotion:
    """The motion that the model of a program simulates; gravity: of the scene [m/s2], (3,).

    Accelerations are those of the program's own mass, inertia and gravity in each state.
    """

    def __init__(self, program: ProgramModel, scene: Scene) -> None:
        self._program = program
        self._wrench = None if scene.is_free else wrench(scene)
        self.gravity = np.zeros(3) if scene.gravity is None else np.array(scene.gravity)

    def at(self, times: Array) -> Kinematics:
        """Return the motion at increasing times [s]; before the start, that of the start."""
        program = self._program
        rows = program.simulate(program.clock.physics_times(np.maximum(times, 0.0), program.rounding), FINE)
        axes, v_world, w_world = rows[:, 3:12].reshape(-1, 3, 3), rows[:, 12:15], rows[:, 15:18]
        w_body = in_axes(axes, w_world)
        pulls = np.zeros((len(times), 6))
        if self._wrench is not None:
            pulls = self._wrench(np.hstack((rows[:, 0:3], rows[:, 18:22], rows[:, 12:18])))
        spun = np.cross(w_body, program.moments * w_body)
        torque = in_axes(axes, pulls[:, 3:6]) - program.gyroscopic * spun
        a_world = program.gravity + pulls[:, 0:3] / program.mass
        return Kinematics(axes, v_world, a_world, w_body, torque / program.moments)
