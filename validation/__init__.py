"""Validation: independent oracles and many random inputs. Run from the checkout, not part of the wheel."""
