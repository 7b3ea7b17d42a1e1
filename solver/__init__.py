"""FLOOR 0: numbers in, numbers out; knows no scene, file or engine."""
