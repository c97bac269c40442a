"""What is said of the poses found: what speaks against each, the motion left free, the next contact to make."""
