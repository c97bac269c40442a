"""Robot calibration: the parameters of a robot from touches on fixtures at unknown poses."""
