"""Contacts on one feature in, every candidate surface out. The localizers do not know of each other."""
