"""The version of this package, without further imports."""

VERSION = "0.1.0"
