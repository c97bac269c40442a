"""The command line: arguments, one call, one report, an exit status. No logic."""
