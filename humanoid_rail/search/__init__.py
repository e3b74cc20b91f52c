"""Global planning where the local method gets stuck."""
