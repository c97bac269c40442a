"""Every file of samples/bad gives exactly the message in the text file next to it, in process and by the command."""

import pytest

from tactfix.cli import main
from tactfix.errors import FileError
from tactfix.files.contact_source import load_contacts
from tactfix.files.fixture_file import load_fixture
from tests.support.project import ROOT

BAD = ROOT / "samples" / "bad"
EXPECTED = sorted(BAD.glob("*.expected"))
NAMES = [path.name.removesuffix(".expected") for path in EXPECTED]


@pytest.fixture(autouse=True)
def _in_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    """Change to the folder, because messages name the path as given: here the file name alone."""
    monkeypatch.chdir(BAD)


def test_no_bad_file_is_without_its_message() -> None:
    files = {path.name for path in BAD.iterdir() if path.suffix != ".expected"} - {"fixture.yaml"}
    assert files == set(NAMES)
    assert len(NAMES) >= 100


def test_the_fixture_next_to_them_is_valid() -> None:
    assert list(load_fixture("fixture.yaml").features) == ["bar", "ball"]


@pytest.mark.parametrize("name", NAMES)
def test_the_message_is_the_expected_one(name: str) -> None:
    with pytest.raises(FileError) as caught:
        load_fixture(name) if name.endswith(".yaml") else load_contacts(name, load_fixture("fixture.yaml"))
    assert f"{caught.value.on_command_line}\n" == (BAD / f"{name}.expected").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_the_command_prints_the_message_and_exits_with_3(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = [name, "nowhere.csv"] if name.endswith(".yaml") else ["fixture.yaml", name]
    status = main(["locate", *arguments])
    out, err = capsys.readouterr()
    assert (status, out) == (3, "")
    expected = (BAD / f"{name}.expected").read_text(encoding="utf-8")
    assert err == "".join(f"tactfix: {line}\n" for line in expected.splitlines())


def test_every_message_states_a_remedy() -> None:
    """Each message states the problem and, after a semicolon, the remedy."""
    for path in EXPECTED:
        for line in path.read_text(encoding="utf-8").splitlines():
            assert line.partition(": ")[2].count("; ") >= 1, line
