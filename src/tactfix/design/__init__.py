"""What a fixture's geometry promises before anyone touches it: motions, symmetries, contacts, accuracy, blind spots."""
