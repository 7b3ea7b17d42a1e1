"""Which engines there are, where they are installed, and whether they keep the contract."""
