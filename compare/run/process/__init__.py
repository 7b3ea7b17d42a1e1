"""Processes that answer in messages, and what they have answered, kept on disk."""
