"""Objects in hands: where they are along a motion, and what that means for its bodies."""
