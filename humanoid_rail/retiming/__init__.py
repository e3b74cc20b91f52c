"""The fastest timing of a path within the joint limits, at rest at both ends."""
