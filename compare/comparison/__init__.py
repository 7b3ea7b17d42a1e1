"""The error of every contestant on a scene."""
