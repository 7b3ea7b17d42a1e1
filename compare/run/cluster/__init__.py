"""The workers of a Dask cluster: tasks run there, and what is saved is saved at home."""
