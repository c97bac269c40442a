"""A folder with a fixture and contacts, and a stub of locate that returns a chosen status."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tactfix.locate_result import LocateResult
from tactfix.results import Status
from tests.support.answers import LOCATING, answer
from tests.support.file_texts import PAPER, contact_text, written


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    written(tmp_path, PAPER, "fixture.yaml")
    written(tmp_path, contact_text(), "contacts.csv")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def answers(monkeypatch: pytest.MonkeyPatch) -> Callable[[Status], None]:
    """Replace locate by a stub that returns the given status."""

    def set_status(status: Status) -> None:
        def locate(*_: object, **__: object) -> LocateResult:
            return answer(status)

        monkeypatch.setattr(LOCATING, "locate", locate)

    return set_status
