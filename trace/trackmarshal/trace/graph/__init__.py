"""Everything that traces to something, as one graph: nodes with stable ids, typed links, and what a project's schema asks of them."""
