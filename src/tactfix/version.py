"""The version of this package, where reading it costs nothing."""

VERSION = "0.1.0"
