"""A throw as some program simulates it, with its mistakes, and the reference motion; compiled in `kernel`."""
