"""The robot: its data, and where robots come from."""
