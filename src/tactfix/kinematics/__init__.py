"""Serial chains of joints: where the tip is, and how it moves with every geometric parameter of the robot."""
