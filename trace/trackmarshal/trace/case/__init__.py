"""The safety case as a document: one content, taken from the link graph and the matrix, printed as HTML and as Typst's source for PDF."""
