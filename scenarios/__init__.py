"""FLOOR 0: the questions (scene files and their types) and their true answers; never imports solver/."""
