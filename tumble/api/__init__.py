"""What `import tumble` provides: scenes, contestants, and one function per command, with tables as results."""
