"""Meshes: their files, the solids in them, and convex bodies that contain these."""
