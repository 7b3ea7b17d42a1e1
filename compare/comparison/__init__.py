"""Who is wrong on a throw, and by how much."""
