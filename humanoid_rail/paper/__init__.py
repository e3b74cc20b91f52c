"""Section 5 of the paper: cases, claims, figures; and its DH table by hand."""
