"""FLOOR 1: puts one question to every engine, and judges the answers."""
