"""The fit of one feature alone to contacts."""
