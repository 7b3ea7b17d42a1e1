"""Reads a trajectory that any program wrote, or says in one line what it leaves unsaid."""
