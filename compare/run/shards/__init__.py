"""Parts of a command that run apart, each of which leaves a folder, and the whole command made of these folders."""
