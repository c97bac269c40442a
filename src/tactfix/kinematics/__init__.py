"""Serial chains of joints: the place of the tip and its derivatives by the geometric parameters of the robot."""
