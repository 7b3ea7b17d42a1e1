"""The scenes that come with Tumble, one TOML file each."""
