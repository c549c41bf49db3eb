"""The command: one module a verb; each imports its heavy parts when it is called."""
