"""The tables that others script against: what is in them, writing, reading."""
