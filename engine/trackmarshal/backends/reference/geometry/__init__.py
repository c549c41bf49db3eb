"""The definitions of docs/geometry.md one by one, in plain Python: the oracle of `runtime.geometry`."""
