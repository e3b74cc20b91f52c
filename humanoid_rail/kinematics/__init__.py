"""What is true of a robot among obstacles at a configuration; tasks; inverse kinematics."""
