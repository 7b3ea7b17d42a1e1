"""Tables to pages, pictures and terminal text; draws, never computes."""
