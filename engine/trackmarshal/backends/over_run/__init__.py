"""Rules over the run: what they say in a cycle about it and about earlier ones, whatever evaluates their leaves."""
