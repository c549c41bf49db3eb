"""The matrix page: all that the graph has in one JSON, and the script that walks it."""
