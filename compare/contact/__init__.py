"""Engines above a rigid plane: which law of contact each has, apart from the error of its step."""
