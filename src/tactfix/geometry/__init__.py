"""Rigid motions and surfaces: the geometry that everything above is written in."""
