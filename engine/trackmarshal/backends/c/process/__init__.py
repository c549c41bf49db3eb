"""A generated Supervisor as a process of its own: its messages as one table, and the C that is made of the table."""
