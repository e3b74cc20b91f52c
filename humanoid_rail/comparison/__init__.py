"""Compares methods and engines, others' too: what `humanoid-rail evaluate` and `humanoid-rail benchmark` show."""
