"""Where the project's own files are."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
FIXTURES = ROOT / "fixtures"
PLATE_FILE = FIXTURES / "robot-cell-plate.yaml"
BAD_DESIGNS = ROOT / "tests" / "design" / "bad"
