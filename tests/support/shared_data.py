"""Reference data next to the checkout, or in the folder given by the environment variable TACTFIX_SHARED."""

import os
from pathlib import Path

import pytest

from tests.support.project import ROOT


def shared_data(*parts: str) -> Path:
    """A file or folder of the reference data; the test is skipped if it does not exist."""
    path = Path(os.environ.get("TACTFIX_SHARED", ROOT.parent / "shared")).joinpath(*parts)
    if not path.exists():
        pytest.skip(f"reference data: {path} is not there")
    return path
