"""Checks of certificates by an independent geometry. Run from a checkout: `python -m validation.check_certificates`."""
