"""Programs of a body that bounces, slides and rolls on a plane, right and with a mistake, on which grade is scored.

Nothing here imports Tumble: scenes, simulators and mistakes are written again; only its command is run.
"""
