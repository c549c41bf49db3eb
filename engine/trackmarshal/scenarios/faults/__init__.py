"""Fault injection: declared faults are put into a recording, which the Supervisor then runs through; docs/faults.md."""
