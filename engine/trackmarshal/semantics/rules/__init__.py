"""Rules and assumptions: where clauses may stand, what they mean, and what they trace to."""
