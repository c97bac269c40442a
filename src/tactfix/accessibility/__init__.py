"""The touchable parts of a fixture, and whether the straight approach to a contact is free."""
