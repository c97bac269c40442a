"""The fixture files that come with tactfix, as something to start from."""

from pathlib import Path
from typing import Final

from tactfix.errors import UsageError
from tactfix.files.reading import decode, read_bytes
from tactfix.wording import did_you_mean

TEMPLATES: Final = ("cylinder-sphere", "three-spheres", "three-planes", "robot-cell-plate", "machine-tool-ball-bar")


def template_text(name: str) -> str:
    """The text of the fixture file of that name; UsageError where there is none."""
    if name not in TEMPLATES:
        raise UsageError(f"there is no template {name!r}; {did_you_mean(name, TEMPLATES)}")
    path = _folder() / f"{name}.yaml"
    return decode(str(path), read_bytes(path))


def _folder() -> Path:
    """Inside the package where it is installed, beside src in a checkout."""
    package = Path(__file__).parents[1]
    packaged = package / "fixtures"
    return packaged if packaged.is_dir() else package.parents[1] / "fixtures"
