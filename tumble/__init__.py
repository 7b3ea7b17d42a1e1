"""FLOOR 3: the command line, and nothing else."""
