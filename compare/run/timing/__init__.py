"""What a step takes, and how sure that is."""
