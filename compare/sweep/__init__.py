"""What each digit costs, in run time."""
