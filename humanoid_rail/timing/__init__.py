"""How fast motions can be: along smooth paths, and at the least."""
