"""Rules for readers: formulas (MathML, Typst, text) and sentences, from the typed tree."""
