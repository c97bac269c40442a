"""What a probe can touch, and whether it could have come to a contact in a straight line."""
