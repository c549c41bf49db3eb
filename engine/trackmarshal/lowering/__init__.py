"""The typed tree to the core that evaluators run: names, definitions and the author's words are written out."""
