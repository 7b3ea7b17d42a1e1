"""Collocation in three stages: all of gauss6 and radau5 but their numbers.

Over a step the slope of the state is a parabola in time, right at three instants, the stages.  `scheme` has a method as
numbers, `equations` what the equations of motion ask of the slopes, `changes` how that changes with the state,
`corrections` what slopes want by that, `newton` finds the slopes, `steps` takes the steps; `turning` takes those of a
rotation that no torque acts on.

Source: Hairer & Wanner, "Solving Ordinary Differential Equations II" (1996), sections IV.5 and IV.8.
"""
