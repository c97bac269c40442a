"""Robot calibration: the parameters of a robot from touches on fixtures that stand at unknown places."""
