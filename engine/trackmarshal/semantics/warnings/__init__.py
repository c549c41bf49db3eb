"""What compiles and is hardly meant: one class a warning, by what it is about."""
