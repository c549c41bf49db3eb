"""A planner's output as it is, held against the input contract: what its columns are, what has to be converted, what does not fit."""
