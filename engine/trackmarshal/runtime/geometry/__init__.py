"""Swept footprints, corridors, clearances and curvilinear coordinates over numpy arrays."""
