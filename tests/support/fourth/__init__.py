"""The language once more, by an evaluator that shares nothing with the engine: `meaning`, and random specs of its constructs, `writing`."""
