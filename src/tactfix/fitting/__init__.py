"""One feature alone, fitted to contacts, and what comes of it."""
