"""What a trajectory shows when it is held against the reference motion: errors, conserved quantities, noise."""
