"""Reference data that lie beside the checkout, or where the environment variable TACTFIX_SHARED says."""

import os
from pathlib import Path

import pytest

from tests.support.project import ROOT


def shared_data(*parts: str) -> Path:
    """A file or folder of the reference data; the test is skipped where it is not there."""
    path = Path(os.environ.get("TACTFIX_SHARED", ROOT.parent / "shared")).joinpath(*parts)
    if not path.exists():
        pytest.skip(f"reference data: {path} is not there")
    return path
