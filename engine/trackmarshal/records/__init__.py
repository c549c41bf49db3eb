"""The small records that the engine writes and `trackmarshal.trace` reads: specs, tests and runs as facts.

They travel as JSON: as results in the evidence store (`trackmarshal.store`), or one `ResultsFile` a file. Files are UTF-8,
strict JSON; paths in them are relative to the project, with forward slashes; times are ISO 8601 with an offset.
Fields are added over time and never renamed: readers ignore fields that they do not know and refuse files of a newer
version. Nothing here imports more than the standard library.
"""
