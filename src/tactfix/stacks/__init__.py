"""Many minimal problems of one kind at once: the closed-form localizers for stacks of contacts."""
