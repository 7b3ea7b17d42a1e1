"""What engine files of ours share.  A folder is no engine: the registry lists files only."""
