"""The check of a fixture's design before it is touched: motions, symmetries, contacts, accuracy, blind spots."""
