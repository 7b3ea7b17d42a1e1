"""How everybody moves: truth and contestants at enough instants to be watched, with what a free body keeps."""
