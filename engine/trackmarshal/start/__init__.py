"""New projects, and new pieces of one: files that are right from the start, written where nothing is yet."""
