"""Joint estimation of the fixture's pose and of an unknown tip offset, tip radius, or both."""
