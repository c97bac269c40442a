"""The fixture files that come with tactfix, as something to start from."""

from typing import Final

from tactfix.errors import UsageError
from tactfix.files.reading import decode, read_bytes
from tactfix.fixture_format.json_schema import fixtures_folder
from tactfix.wording import did_you_mean

TEMPLATES: Final = ("cylinder-sphere", "three-spheres", "three-planes", "robot-cell-plate", "machine-tool-ball-bar")


def template_text(name: str) -> str:
    """The text of the fixture file of that name; UsageError where there is none."""
    if name not in TEMPLATES:
        raise UsageError(f"there is no template {name!r}; {did_you_mean(name, TEMPLATES)}")
    path = fixtures_folder() / f"{name}.yaml"
    return decode(str(path), read_bytes(path))
