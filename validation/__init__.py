"""Validation: checks against independent oracles on many random inputs. Run from the checkout, not part of the wheel."""
