"""Files: plans in folders, and exports to the formats of other tools."""
