"""Qualification of a probe: sigma from repeated touches, effective tip radius from a reference ball."""
