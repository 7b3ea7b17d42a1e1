"""What may be wrong with a program, as data: mistakes, one by one, and the schemes of engines."""
