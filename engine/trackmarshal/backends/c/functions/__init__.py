"""The C functions of rules: nodes of the IR become trees of C, function by function."""
