"""Who is stable where, and what each does with extreme cases."""
