"""The only code that opens files: fixture YAML, contact CSV, results whole or not at all."""
