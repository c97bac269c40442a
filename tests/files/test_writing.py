"""Files are written completely or not at all."""

import os
import stat
from pathlib import Path

import pytest

from tactfix.errors import FileError
from tactfix.files.writing import write_whole


def test_a_new_file_and_an_old_one(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    write_whole(path, "one\n\u00e4")
    assert path.read_bytes() == "one\n\u00e4".encode()
    mask = os.umask(0)
    os.umask(mask)
    assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~mask
    path.chmod(0o640)
    write_whole(path, b"\x00two")
    assert path.read_bytes() == b"\x00two"
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert list(tmp_path.iterdir()) == [path]


def test_a_symbolic_link_keeps_its_target(tmp_path: Path) -> None:
    path, link = tmp_path / "a.txt", tmp_path / "link"
    path.write_text("old")
    link.symlink_to(path)
    write_whole(link, "new")
    assert link.is_symlink()
    assert path.read_text() == "new"


def test_special_files_are_written_directly() -> None:
    write_whole(os.devnull, "gone")
    assert Path(os.devnull).is_char_device()


def test_the_old_file_stays_when_writing_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")

    def no_space(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", no_space)
    with pytest.raises(FileError, match="No space left"):
        write_whole(path, "new")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_places_where_nothing_can_be_written(tmp_path: Path) -> None:
    for path, word in ((tmp_path, "directory"), (tmp_path / "no" / "a.txt", "does not exist")):
        with pytest.raises(FileError, match=word) as caught:
            write_whole(path, "x")
        assert caught.value.path == str(path)
