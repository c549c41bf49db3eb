"""The sections of the document, one module a subject; `content` puts them in their order."""
