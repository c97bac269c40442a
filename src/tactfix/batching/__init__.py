"""Many contact sets: the location of one set, its row of results, and worker processes."""
