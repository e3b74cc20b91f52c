"""Follows targets that move, among obstacles that move, with a proven stop at all times."""
