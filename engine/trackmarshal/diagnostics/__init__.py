"""What goes wrong, said well: one class an error, one renderer a format."""
