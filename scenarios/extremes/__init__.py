"""Extreme cases, one TOML file each: free flights with an exact truth at the ends of what numbers can be."""
