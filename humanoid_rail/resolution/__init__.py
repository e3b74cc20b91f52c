"""Redundancy resolution at the velocity level: eq. 4.6 to 4.9, the QP on top of it, and motions that follow them."""
