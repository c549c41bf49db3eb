"""A module as a picture: what is in it, how large each element is, where it stands, and how it is drawn."""
