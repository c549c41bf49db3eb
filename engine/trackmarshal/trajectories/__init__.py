"""Columns of trajectories: read, completed, converted, cut at rest, resampled. What a planner's output takes to keep the contract."""
