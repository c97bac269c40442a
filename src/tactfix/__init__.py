"""tactfix: where a fixture stands, from a handful of touches."""
