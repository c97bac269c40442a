"""The diagnosis: the mistakes that explain why no pose fits the contacts."""
