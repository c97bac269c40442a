"""The table of classic mistakes in fixtures/README.md: each mistake gives the quoted message, with the page's plate."""

import re
from pathlib import Path

import pytest

from tests.api.pages import ROOT, folder_for_examples
from tests.support.command_line import tactfix

PAGE = ROOT / "fixtures" / "README.md"
ROW = re.compile(r"^\| ([^|]+) \| inconsistent(?:, \"([^\"]+)\")?[^|]*\|$", re.MULTILINE)
SEEN = dict(ROW.findall(PAGE.read_text(encoding="utf-8")))
FILES = {
    "a diameter written as radius": ("my-plate.yaml", "radius: 8.0", "radius: 16.0"),
    "the tip radius forgotten, or given": ("touches.csv", "# tip_radius: 2", "# tip_radius: 0"),
    "the approach written as the surface normal": ("touches.csv", ",ax,ay,az", ",nx,ny,nz"),
    "metres taken for millimetres": ("touches.csv", "# units: mm", "# units: m"),
    "a pin written as a bore": ("my-plate.yaml", "type: cylinder,", "type: cylinder, side: inner,"),
}
"""By the beginning of a row of the table: the file with the mistake, the correct text, and its replacement."""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(folder_for_examples(PAGE, tmp_path))
    assert tactfix("plan", "my-plate.yaml", "--contacts", "10", "--quiet", "--output", "plan.csv").returncode == 0
    simulate = ("simulate", "my-plate.yaml", "plan.csv", "--seed", "1", "--output")
    assert tactfix(*simulate, "touches.csv").returncode == 0
    assert tactfix(*simulate, "swapped.csv", "--fault", "swapped-labels:1").returncode == 0
    return tmp_path


def test_the_table_quotes_the_messages(folder: Path) -> None:
    assert tactfix("locate", "my-plate.yaml", "touches.csv").returncode == 0
    for beginning, (name, right, wrong) in FILES.items():
        text = Path(name).read_text(encoding="utf-8")
        assert text.count(right) >= 1, beginning
        Path(name).write_text(text.replace(right, wrong), encoding="utf-8")
        ran = tactfix("locate", "my-plate.yaml", "touches.csv")
        Path(name).write_text(text, encoding="utf-8")
        assert_seen(ran.returncode, ran.stderr, beginning)
    ran = tactfix("locate", "my-plate.yaml", "swapped.csv")
    assert_seen(ran.returncode, ran.stderr, "two labels exchanged")
    assert len(SEEN) == len(FILES) + 1


def assert_seen(status: int, output: str, beginning: str) -> None:
    """The status is inconsistent, and the output contains the words that the page quotes."""
    (words,) = (words for mistake, words in SEEN.items() if mistake.startswith(beginning))
    assert status == 6, beginning
    assert words in output, beginning
