"""Holds one answer against the truth: errors, what mechanics keeps, orders, agreement, verdicts."""
