"""IR to something that runs or reads: reference, numpy, c, latex, english."""
