"""Table 4.1 of the coursework report that Tumble starts from: how far every contestant is from its printed columns."""
