"""One file a command; its imports are made only when it runs."""
