"""The vectorised evaluator: a whole batch at once."""
