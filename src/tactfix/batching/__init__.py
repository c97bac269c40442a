"""Many contact sets at once: one set as a task, its answer as a row, and who does the work."""
