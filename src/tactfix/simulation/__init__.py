"""Contacts as a probe would make them, with noise, and with the mistakes that cells make."""
