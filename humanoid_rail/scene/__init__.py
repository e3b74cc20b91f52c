"""Scenes: obstacles and targets as validated data, and files of them."""
