"""Planning methods, the planner, verification and many plans at once."""
