"""Proofs that a motion touches nothing, including between samples."""
