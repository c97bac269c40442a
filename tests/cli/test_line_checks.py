"""Checks that all commands share (numbers, standard input, outputs, control characters), and interrupted commands."""

import json
import os
import signal
import socket
from pathlib import Path
from typing import NoReturn

import pytest

from tactfix.batching.cluster import ClusterError, DaskCluster
from tactfix.cli import app, main
from tactfix.files.contact_source import load_contacts
from tactfix.files.fixture_file import load_fixture
from tactfix.files.writing import whole_file
from tactfix.wording import printable, spreadsheet_cell
from tests.support.project import ROOT

FIXTURE = ROOT / "fixtures" / "robot-cell-plate.yaml"
CONTACTS = ROOT / "samples" / "robot-cell-plate" / "contacts.csv"


@pytest.mark.parametrize(
    "words",
    [
        ("--sigma", "1_0"),
        ("--sigma=nan",),
        ("--sigma", "1e31"),
        ("--sigma", "0." + "1" * 400),
        ("--tip-radius", "\u0663"),
        ("--tip-radius", "3mm"),
        ("--max-sigma", "small"),
        ("--max-sigma", "inf"),
        ("--max-rms", "Infinity"),
        ("--at", "1e308,0,0"),
        ("--at", "1_0,0,0"),
        ("--at", "nan,0,0"),
        ("--at", "1,2"),
        ("--tip-offset", "\u0661,0,0"),
    ],
    ids=str,
)
def test_invalid_numbers_are_usage_errors(words: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["locate", str(FIXTURE), str(CONTACTS), *words]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith(f"tactfix: {words[0].partition('=')[0]} ")
    assert "number" in err
    assert len(err) < 300


@pytest.mark.parametrize(("option", "text"), [("--sigma", "0,08"), ("--tip-radius", "-,5"), ("--max-rms", "+12,25")])
def test_a_decimal_comma_is_quoted_with_the_advice_to_use_a_point(
    option: str, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["locate", str(FIXTURE), str(CONTACTS), f"{option}={text}"]) == 2
    assert (
        capsys.readouterr().err == f"tactfix: {option} {text!r} is not a number; write a decimal point, as in 0.005\n"
    )


@pytest.mark.parametrize("starts", ["0", "10001", "1" * 30])
def test_the_starts_of_a_plan_have_a_bound(starts: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plan", str(FIXTURE), "--starts", starts]) == 2
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    "words",
    [
        ("locate", str(FIXTURE), "-", "--near", "-"),
        ("locate", str(FIXTURE), "-", "--work-offset", "-"),
        ("check", str(FIXTURE), "-", "--reference", "-"),
        ("compare", "-", "-"),
        ("convert", "-", "--on", "-", "--to", "kuka"),
        ("simulate", str(FIXTURE), "-", "--pose", "-"),
        ("guide", str(FIXTURE), "--work-offset", "-"),
        ("batch", str(FIXTURE), "-", "-"),
    ],
    ids=lambda words: " ".join(words[:1]),
)
def test_standard_input_is_read_once(words: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*words]) == 2
    assert "can be read only once" in capsys.readouterr().err


@pytest.mark.parametrize("way", ["same", "link", "dots"])
@pytest.mark.parametrize("which", ["plate.yaml", "c.csv"])
def test_an_output_that_is_an_input_is_refused(
    tmp_path: Path, which: str, way: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "plate.yaml").write_bytes(FIXTURE.read_bytes())
    (tmp_path / "c.csv").write_bytes(CONTACTS.read_bytes())
    (tmp_path / "link").symlink_to(tmp_path / which)
    output = {"same": tmp_path / which, "link": tmp_path / "link", "dots": tmp_path / ".." / tmp_path.name / which}[way]
    before = (tmp_path / which).read_bytes()
    assert main(["locate", str(tmp_path / "plate.yaml"), str(tmp_path / "c.csv"), "-o", str(output)]) == 2
    assert "write the result to another file" in capsys.readouterr().err
    assert (tmp_path / which).read_bytes() == before


@pytest.mark.parametrize(
    "words",
    [
        ("locate", str(FIXTURE), str(CONTACTS)),
        ("simulate", str(FIXTURE), "--seed", "3"),
        ("batch", str(FIXTURE), str(CONTACTS), "--jobs", "1"),
        ("convert", str(CONTACTS.with_name("expected.json")), "--to", "kuka"),
        ("schema",),
    ],
    ids=lambda words: words[0],
)
@pytest.mark.parametrize("dash", [("--output", "-"), ("-o", "-"), ("--output=-",), ("-o-",)], ids=lambda dash: dash[-1])
def test_a_dash_as_output_is_standard_output(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: tuple[str, ...],
    dash: tuple[str, ...],
) -> None:
    monkeypatch.chdir(tmp_path)
    status = main([*words])
    out = capsys.readouterr().out
    assert out
    assert main([*words, *dash]) == status
    assert capsys.readouterr().out == out
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("named", [("--output", "./-"), ("-o", "./-"), ("-o./-",)], ids=lambda named: named[-1])
def test_a_file_may_be_called_a_dash(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], named: tuple[str, ...]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["schema", *named]) == 0
    assert capsys.readouterr().out == ""
    assert json.loads((tmp_path / "-").read_text(encoding="utf-8"))["title"] == "tactfix fixture"


def test_a_fixture_file_is_started_on_standard_output(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["init", "-"]) == 0
    assert capsys.readouterr().out.startswith("#")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "option"),
    [
        (("locate", str(FIXTURE), str(CONTACTS)), "--next-contact"),
        (("design-check", str(FIXTURE)), "--junit"),
        (("check", str(FIXTURE), str(CONTACTS), "--reference", "pose.json"), "--history"),
    ],
    ids=lambda words: words[0] if isinstance(words, tuple) else words,
)
def test_secondary_outputs_cannot_be_standard_output(
    words: tuple[str, ...], option: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*words, option, "-"]) == 2
    assert capsys.readouterr() == (
        "",
        f"tactfix: {option} - would mix with the result on standard output; name a file\n",
    )


def test_the_verdict_is_printed_if_the_history_cannot_be_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pose = str(tmp_path / "reference.json")
    assert main(["locate", str(FIXTURE), str(CONTACTS), "--output", pose]) == 0
    words = ["check", str(FIXTURE), str(CONTACTS), "--reference", pose, "--limit-translation", "5"]
    assert main([*words, "--history", str(tmp_path / "nowhere" / "h.jsonl")]) == 3
    out, err = capsys.readouterr()
    assert "moved" in out.splitlines()[0]
    assert "the check cannot be appended" in err


def test_errors_of_output_and_history_are_both_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pose, nowhere = str(tmp_path / "reference.json"), tmp_path / "nowhere"
    assert main(["locate", str(FIXTURE), str(CONTACTS), "--output", pose]) == 0
    words = ["check", str(FIXTURE), str(CONTACTS), "--reference", pose, "--history", str(nowhere / "h.jsonl")]
    assert main([*words, "--output", str(nowhere / "verdict.txt")]) == 3
    err = capsys.readouterr().err
    assert "h.jsonl: the check cannot be appended" in err
    assert "verdict.txt: its directory does not exist" in err


def test_the_ending_of_the_output_chooses_json_for_two_poses_too(tmp_path: Path) -> None:
    pose, written = str(CONTACTS.with_name("expected.json")), tmp_path / "moved.json"
    assert main(["compare", pose, pose, "--output", str(written)]) == 0
    assert json.loads(written.read_text(encoding="utf-8"))["distance"] == 0


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
@pytest.mark.parametrize("swallowed", [False, True])
def test_both_signals_clean_up_and_print_one_line(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    number: signal.Signals,
    status: int,
    swallowed: bool,
) -> None:
    """Swallowed: compiled code that is being imported replaces the interrupt by an error of its own."""

    def stopped(words: object) -> NoReturn:
        try:
            with whole_file(tmp_path / "out.csv"):
                os.kill(os.getpid(), number)
                raise AssertionError
        except KeyboardInterrupt:
            if swallowed:
                raise ImportError("numpy could not be imported") from None
            raise

    monkeypatch.setattr(app, "run_application", stopped)
    before = signal.getsignal(signal.SIGTERM)
    assert main(["locate"]) == status
    assert capsys.readouterr().err in ("tactfix: interrupted\n", "tactfix: terminated\n")
    assert list(tmp_path.iterdir()) == []
    assert signal.getsignal(signal.SIGTERM) == before


@pytest.mark.parametrize(
    "address", ["nonsense", "ucx://a:1", "tcp://a:0", "tcp://a:99999", "tcp://", "tcp://no.such.host.invalid:8786"]
)
def test_an_invalid_address_is_reported_at_once(address: str) -> None:
    pytest.importorskip("distributed")
    with pytest.raises(ClusterError, match="no Dask scheduler answers"), DaskCluster(address).open():
        pass


def test_a_closed_port_is_reported_at_once() -> None:
    pytest.importorskip("distributed")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(ClusterError, match="no Dask scheduler answers"), DaskCluster(address).open():
            pass


def test_control_characters_do_not_reach_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    assert printable("a\x1b[31m\x9b\u202e\u2028\r\x00b\n\t\u00e9") == "a\\x1b[31m\\x9b\\u202e\\u2028\\r\\x00b\n\t\u00e9"
    assert main(["locate", "no\x1b[2J\x07.yaml", "c.csv"]) == 3
    assert "\x1b" not in capsys.readouterr().err


def test_names_with_control_characters_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = FIXTURE.read_text(encoding="utf-8")
    for old, new in (("name: robot-cell-plate", 'name: "a\\nG54"'), ("  pin: {type", '  "p\\ein": {type')):
        (tmp_path / "f.yaml").write_text(text.replace(old, new))
        assert main(["locate", str(tmp_path / "f.yaml"), str(CONTACTS)]) == 3
    message = capsys.readouterr().err
    assert "control character" in message
    assert "\x1b" not in message
    (tmp_path / "c.csv").write_text(CONTACTS.read_text(encoding="utf-8").replace("pin,", "p\x1bin,"))
    assert main(["locate", str(FIXTURE), str(tmp_path / "c.csv")]) == 3
    message = capsys.readouterr().err
    assert "there is a control character, '\\x1b'" in message
    assert "\x1b" not in message


def test_a_cell_that_a_spreadsheet_would_execute_is_read_back_unchanged(tmp_path: Path) -> None:
    assert [spreadsheet_cell(text) for text in ("=1+1", "+x", "-x", "@x", "x=", "", "1")] == [
        *("'=1+1", "'+x", "'-x", "'@x"),
        *("x=", "", "1"),
    ]
    text = FIXTURE.read_text(encoding="utf-8").replace("  pin:", '  "=pin":').replace("  ball:", "  -ball:")
    (tmp_path / "f.yaml").write_text(text)
    assert main(["simulate", str(tmp_path / "f.yaml"), "--seed", "1", "-o", str(tmp_path / "c.csv")]) == 0
    written = (tmp_path / "c.csv").read_text()
    assert "\n'=pin," in written
    assert "\n'-ball," in written
    contacts = load_contacts(tmp_path / "c.csv", load_fixture(tmp_path / "f.yaml"))
    assert set(contacts.features) == {"plate", "=pin", "-ball"}
