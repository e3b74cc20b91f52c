"""Motions of least time, by optimisation of a spline."""
