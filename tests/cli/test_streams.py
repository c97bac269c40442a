"""Standard streams that are closed or full: the exit status shows it, and it is not reported as a bug."""

import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

from tactfix.cli.output import progress_bar
from tests.support.command_line import tactfix
from tests.support.project import ROOT

FIXTURE = ROOT / "fixtures" / "cylinder-sphere.yaml"
CONTACTS = ROOT / "samples" / "cylinder-sphere" / "contacts.csv"
pytestmark = pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")


def shell(words: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "T": f"{sys.executable} -m tactfix", "F": str(FIXTURE), "C": str(CONTACTS)}
    return subprocess.run(["sh", "-c", words], env=environment, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("words", ["$T locate $F $C > /dev/full", "$T locate $F $C >&-", "$T --version > /dev/full"])
def test_a_result_that_cannot_be_written_is_reported(words: str) -> None:
    done = shell(words)
    assert done.returncode == 3
    (line,) = done.stderr.splitlines()
    assert line.startswith("tactfix: standard output: cannot be written: ")
    assert "--output" in line


@pytest.mark.parametrize(
    ("words", "status"),
    [
        ("$T locate $F none 2> /dev/full", 3),
        ("$T locate $F none 2>&-", 3),
        ("$T locate 2> /dev/full", 2),
        ("$T locate $F $C 2>&-", 0),
        ("$T locate -v $F $C 2> /dev/full", 0),
    ],
)
def test_the_status_is_correct_without_standard_streams(words: str, status: int) -> None:
    assert shell(words).returncode == status


def test_a_terminal_of_zero_columns_has_an_unknown_width() -> None:
    assert "located" in shell("COLUMNS=0 $T locate -v $F $C").stderr


def test_a_failed_summary_does_not_change_the_status(tmp_path: Path) -> None:
    shell(f"{{ $T locate -v $F $C > {tmp_path}/pose; echo $? > {tmp_path}/status; }} 2>&1 | true")
    assert (tmp_path / "status").read_text() == "0\n"
    assert len((tmp_path / "pose").read_text().splitlines()) == 4


@pytest.mark.parametrize("words", ["$T locate $F - <&-", "$T convert - --to kuka <&-"])
def test_an_input_that_is_closed_is_empty(words: str) -> None:
    done = shell(words)
    assert done.returncode == 3
    assert done.stderr.startswith("tactfix: standard input: ")


@pytest.mark.parametrize("words", [("batch", FIXTURE, "-", "-"), ("compare", "-", "-")])
def test_standard_input_is_read_only_once(words: tuple[object, ...]) -> None:
    done = tactfix(*words)
    assert done.returncode == 2
    assert "only once" in done.stderr


@pytest.mark.parametrize("radius", ["1e300", "1e-300", "nan", "-1"])
def test_an_invalid_radius(radius: str) -> None:
    done = tactfix("fit", "sphere", CONTACTS, "--feature", "ball", "--radius", radius)
    assert (done.returncode, done.stdout) == (2, "")
    assert "is not a radius" in done.stderr or "is not a number" in done.stderr


def test_piped_output_is_utf_8_in_any_locale(tmp_path: Path) -> None:
    fixture = tmp_path / "kugel.yaml"
    fixture.write_text(FIXTURE.read_text().replace("bar", "\u68d2 \u00e4"), encoding="utf-8")
    ascii_only = "LC_ALL=C PYTHONUTF8=0 PYTHONCOERCECLOCALE=0 PYTHONIOENCODING=ascii"
    done = shell(f"{ascii_only} $T simulate {fixture} --seed 1 | $T locate {fixture} -")
    assert (done.returncode, done.stderr) == (0, "")
    assert len(done.stdout.splitlines()) == 4


def test_progress_shows_on_a_terminal_and_ends_with_it(monkeypatch: pytest.MonkeyPatch) -> None:
    master, terminal = pty.openpty()
    with os.fdopen(terminal, "w") as stream:
        monkeypatch.setattr(sys, "stderr", stream)
        with progress_bar("planning", quiet=False) as update:
            update(0.5, "half")
        shown = b""
        while b"planning" not in shown:
            shown += os.read(master, 4096)
        os.close(master)
        with progress_bar("planning", quiet=False) as update:
            update(0.5, "for nobody")
