"""The compiled run of a program with mistakes: `dynamics` defines its parts, `stepping` simulates it."""
