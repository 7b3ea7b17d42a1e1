"""What changed between an engine's releases, found from the numbers."""
