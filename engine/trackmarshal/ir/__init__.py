"""The typed intermediate representation: closed sets of nodes, dimensions checked and gone."""
