"""Output on a terminal: the answer first, rounded to its significant digits, and no line broken inside a word."""

import fcntl
import io
import os
import pty
import re
import struct
import subprocess
import sys
import termios
from pathlib import Path

import numpy as np
import pytest

from tactfix.report.text_report import rounded_matrix_text
from tactfix.wording import wrapped, wrapped_comments
from tests.support.command_line import tactfix

ROOT = Path(__file__).parents[2]
STYLE = re.compile(r"\x1b\[[\d;]*m")
PLATE = "fixtures/robot-cell-plate.yaml samples/robot-cell-plate/contacts.csv"
PAPER = "fixtures/cylinder-sphere.yaml samples/cylinder-sphere"


def shown(line: str, width: int, folder: Path) -> str:
    """The output of a command on a terminal of this width."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 50, width, 0, 0))
    kept = {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "LINES", "FORCE_COLOR")}
    environment = {**kept, "NO_COLOR": "1", "TERM": "xterm"}
    command = [sys.executable, "-m", "tactfix", *line.split()]
    process = subprocess.Popen(command, stdin=theirs, stdout=theirs, stderr=theirs, cwd=folder, env=environment)
    os.close(theirs)
    parts = []
    try:
        while part := os.read(ours, 65536):
            parts.append(part)
    except OSError:  # Linux: no process has the other end open any more
        pass
    process.wait(timeout=60)
    os.close(ours)
    return STYLE.sub("", b"".join(parts).decode().replace("\r\n", "\n"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the project's files and some additional ones."""
    place = tmp_path_factory.mktemp("screens")
    for name in ("fixtures", "samples"):
        (place / name).symlink_to(ROOT / name)
    lines = (ROOT / "samples/robot-cell-plate/contacts.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    rows = [line for line in lines if line.startswith(("#", "feature", "plate"))]
    (place / "plate-only.csv").write_text("".join(rows), encoding="utf-8")
    fixture = ROOT / "fixtures" / "robot-cell-plate.yaml"
    tactfix("simulate", fixture, "--seed", 4, "--fault", "reversed-approach:3", "--output", place / "reversed.csv")
    tactfix("locate", *[ROOT / part for part in PLATE.split()], "--output", place / "pose.json")
    return place


SCREENS = {
    "located": f"locate {PLATE} --at 300,180,60",
    "ambiguous": f"locate {PAPER}/contacts-normal.csv",
    "underdetermined": "locate fixtures/robot-cell-plate.yaml plate-only.csv",
    "inconsistent": "locate fixtures/robot-cell-plate.yaml reversed.csv",
    "fit": "fit cylinder samples/cylinder-sphere/contacts.csv --feature bar --radius 1",
    "check": f"check {PLATE} --reference pose.json",
    "guide": "guide fixtures/robot-cell-plate.yaml plate-only.csv",
    "compare": "compare pose.json pose.json",
    "qualify": "qualify reversed.csv",
    "usage": "fit cone nothing.csv",
}


def looked_at(line: str, columns: int) -> str:
    """The output of a command run in this process on a terminal: both streams together, without styles."""
    return STYLE.sub("", tactfix(*line.split(), together=True, columns=columns).stdout)


@pytest.mark.parametrize("name", SCREENS)
def test_nothing_breaks_inside_words_at_60_columns(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    narrow, wide = (looked_at(SCREENS[name], columns) for columns in (60, 240))
    assert max(map(len, narrow.splitlines())) <= 60
    assert set(narrow.split()) == set(wide.split())
    assert "…" not in narrow


def test_a_terminal_of_the_system_is_recognized(folder: Path) -> None:
    text = shown(f"locate {PLATE}", 60, folder)
    assert text.startswith("located; the origin is known to 0.12 mm (95 %, along its")
    assert max(map(len, text.splitlines())) <= 60


def test_the_answer_comes_first_and_in_the_digits_that_are_known(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    text = looked_at(f"locate {PLATE}", 80)
    piped = np.loadtxt(io.StringIO(tactfix("locate", *[ROOT / part for part in PLATE.split()]).stdout))
    answer, *matrix = text.splitlines()[:5]
    assert answer == "located; the origin is known to 0.12 mm (95 %, along its worst direction)"
    read = np.loadtxt(io.StringIO("\n".join(matrix)))
    assert 0 < np.abs(read - piped)[:3, 3].max() < 0.037 / 50
    assert 0 < np.abs(read - piped)[:3, :3].max() < np.deg2rad(0.012) / 25
    assert not (piped == read).all()


def test_the_pose_in_a_controllers_format_follows_the_answer(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    answer, *others = looked_at(f"locate {PLATE} --format kuka", 120).splitlines()
    assert answer.startswith("located; ")
    assert any(line.startswith("{X 1184.194397,") for line in others)


def test_without_a_covariance_every_digit_is_shown() -> None:
    matrix = np.eye(4)
    matrix[0, 3] = 1 / 3
    assert "0.3333333333333333" in rounded_matrix_text(matrix, None)
    assert "0.33333\n" in rounded_matrix_text(matrix, np.eye(6) * 1e-6)


@pytest.mark.parametrize("width", [20, 33, 60])
def test_lines_break_between_words(width: int) -> None:
    text = "  moved 0.100482 mm (sigma 0.11 mm), turned\nshort\n" + "unbroken" * 20 + "\n"
    lines = wrapped(text, width).splitlines()
    assert " ".join(lines).split() == text.split()
    assert all(len(line) <= width or len(line.split()) == 1 for line in lines)
    assert wrapped(text, 1000) == text


@pytest.mark.parametrize("width", [40, 60, 80])
def test_long_comments_of_a_program_are_broken_and_its_lines_are_not(width: int) -> None:
    sigma = "; sigma: X 0.037 mm, Y 0.052 mm, Z 0.063 mm, A 0.012 deg, B 0.013 deg, C 0.019 deg"
    code = "{X 1184.194397,Y -356.701519,Z 412.808508,A -63.988217,B -0.415211,C 0.592494}"
    *comments, last = wrapped_comments(f"{sigma}\n{code}\n", width).splitlines()
    assert last == code
    assert all(len(line) <= width and line.startswith("; ") for line in comments)
    assert " ".join(line.removeprefix("; ") for line in comments) == sigma.removeprefix("; ")
    assert len(comments) > 1
