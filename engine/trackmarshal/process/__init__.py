"""The Supervisor as a process of its own: what talks to it, and what executes its decisions (docs/process.md).

`messages`, `shared_memory`, `datagrams`, `client` and `executing` need nothing but Python: they are what `compile --process` writes
beside the generated C, for machines without trackmarshal.
"""
