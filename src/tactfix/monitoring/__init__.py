"""Watching a fixture: whether it has moved, whether it drifts, and what is still missing while it is touched."""
