"""Stability maps, largest stable steps, and extreme cases."""
