"""The C of a whole Supervisor around the rules: what it is given, its door, what it judges, its state machine and its configuration."""
