"""The argument as goal structure (GSN): made of the link graph and the matrix by templates, checked, split into modules, drawn, exported."""
