"""FLOOR 2: tables -> pages and pictures; draws, never computes."""
