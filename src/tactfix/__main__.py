"""`python -m tactfix`: the command line, even if the script is not on the PATH."""

import sys

from tactfix.cli import main

if __name__ == "__main__":
    sys.exit(main())
