"""Locating a fixture: solutions, their elimination, free motions, the next contact, and the diagnosis."""
