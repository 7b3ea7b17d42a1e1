"""Contact with one rigid plane: three methods, and what they share.

All of it is written in the plane's frame: origin at the plane's point, third axis along its normal.  So a height is a
third component, and what lies along the plane the first two.
"""
