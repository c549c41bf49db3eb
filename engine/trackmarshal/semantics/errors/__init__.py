"""What is wrong with specs, beyond their syntax: one class an error, by what it is about."""
