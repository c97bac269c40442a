"""Monitoring of a fixture: movement, drift, and guidance while it is touched."""
