"""Measurements of the planner, beside other methods and other versions. Run from a checkout: `python -m benchmarks.evaluate` say."""
