"""Export of a plan to MuJoCo."""
