"""The flight of a program with mistakes, compiled: `laws` says what it is made of, `stepping` flies it."""
