"""Generated inputs for property tests."""
