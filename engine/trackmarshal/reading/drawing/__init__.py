"""Where a rule's demand ends to hold: its boundary in two of its inputs, with its tests and what was recorded."""
