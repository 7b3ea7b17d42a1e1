"""Looks for the mistakes that explain a trajectory."""
