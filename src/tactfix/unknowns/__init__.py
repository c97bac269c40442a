"""Where a fixture stands when it is not known where the tip is, or how large: pose, tip and radius found together."""
