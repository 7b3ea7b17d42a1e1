"""Reads a trajectory that any program wrote, or reports in one line what is ambiguous in it."""
