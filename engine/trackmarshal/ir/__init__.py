"""The core: the closed set of nodes that evaluators run, dimensions checked and gone; and compiled specs."""
