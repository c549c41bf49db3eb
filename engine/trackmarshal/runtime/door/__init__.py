"""The one door (S-2-C): what callers hand in becomes a frame, and every breach of the contract in it gets its name."""
