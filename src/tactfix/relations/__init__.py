"""Fixtures given by distances and angles: feature by feature, then all contacts and relations at once."""
