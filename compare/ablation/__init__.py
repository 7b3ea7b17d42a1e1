"""The time saved by switching off features that a scene does not need."""
