"""Benchmarks: what compares planning methods and measures times. Run from the checkout, not part of the wheel."""
