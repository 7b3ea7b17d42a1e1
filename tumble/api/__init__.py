"""What `import tumble` provides: scenes, contestants, and one function per command, with tables as results."""

import logging

# A library leaves its log to the program that uses it.
logging.getLogger("tumble").addHandler(logging.NullHandler())
