"""The application: help without imports, exit status of every error, completion, pipes."""

import json
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterable, Sequence
from importlib.util import find_spec
from pathlib import Path

import pytest

from tactfix.cli import main
from tactfix.cli.application import COMMANDS, module_of
from tactfix.errors import DegenerateContactsError, FileError, MissingExtraError, Problem, UsageError
from tactfix.version import VERSION
from tests.support.answers import LOCATING
from tests.support.command_line import tactfix
from tests.support.project import ROOT

RUN = ("locate", "fixture.yaml", "contacts.csv")
HEAVY = ("numpy", "scipy", "pydantic", "rich", "yaml")


IMPORTING = """
import json, os, sys
from tactfix.cli import main
for words, environment in json.loads(sys.argv[1]):
    os.environ.update(environment)
    try:
        main(words)
    except SystemExit:
        pass
    print("imported", *sys.modules, file=sys.stderr)
"""


def imported_by_each(lines: Iterable[tuple[Sequence[str], dict[str, str]]]) -> list[set[str]]:
    """The modules loaded after each command line with its environment variables; all run in one subprocess."""
    done = subprocess.run(
        [sys.executable, "-c", IMPORTING, json.dumps(list(lines))],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
        cwd=ROOT,
    )
    return [set(line.split()[1:]) for line in done.stderr.splitlines() if line.startswith("imported ")]


def imported(*arguments: str) -> set[str]:
    """The modules that a command line imports, with any exit status."""
    return imported_by_each([(arguments, {})])[0]


def test_the_version_is_that_of_the_project(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"tactfix {VERSION}\n"
    assert tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"] == VERSION


def test_help_lists_every_command_and_what_it_does(capsys: pytest.CaptureFixture[str]) -> None:
    for option in ("--help", "-h"):
        assert main([option]) == 0
        text = " ".join(capsys.readouterr().out.split())
        for name, summary in COMMANDS.items():
            assert f" {name} {summary}" in text


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_exists_and_has_help(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, "--help"]) == 0
    out = capsys.readouterr().out
    assert out.startswith(f"Usage: tactfix {command} ")
    assert (ROOT / "src" / Path(*module_of(command).split("."))).with_suffix(".py").exists()


def test_an_import_reads_logs_alone(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", "--help"]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "--contacts-format NAME What LOG is: linuxcnc, grbl," in shown
    assert "--units U Unit of the log" in shown
    assert "csv" not in shown


def test_help_and_version_import_nothing_heavy() -> None:
    lines = [("--version",), ("--help",), *((name, "--help") for name in COMMANDS)]
    for line, modules in zip(lines, imported_by_each((line, {}) for line in lines), strict=True):
        assert modules.isdisjoint(HEAVY), line


def completing(line: str, word: int) -> dict[str, str]:
    """The environment variables by which a shell requests the completion of a word of this line."""
    return {"_TACTFIX_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(word)}


def test_completion_imports_nothing_heavy() -> None:
    lines = [
        "tactfix lo",
        "tactfix locate --ma",
        "tactfix fit cy",
        "tactfix convert p --to k",
        "tactfix import l.txt -",
    ]
    lines += ["tactfix locate f c --format k", "tactfix simulate f --fault o"]
    calls = [((), completing(line, len(line.split()) - 1)) for line in lines]
    for line, modules in zip(lines, imported_by_each(calls), strict=True):
        assert modules.isdisjoint(HEAVY), line


PAPER = ("fixtures/cylinder-sphere.yaml", "samples/cylinder-sphere/contacts.csv")


def test_locating_imports_only_what_it_uses() -> None:
    modules = imported("locate", *PAPER)
    assert {"numpy", "yaml"} <= modules
    # The diagnosis and the modules of other commands are not imported if the contacts fit.
    assert modules.isdisjoint({"pydantic", "rich", "scipy", "numpy.random", "numpy.ma"})
    others = (
        "pose_formats",
        "diagnosis.diagnose",
        "fixture_format.pydantic_errors",
        "planning",
        "localization.next_contact",
        "relations.combined",
        "localizers.cylinder",
        "explanations",
        "lexer",
    )
    assert all(find_spec(f"tactfix.{name}") for name in others), "a module that is no more cannot be imported"
    assert modules.isdisjoint(f"tactfix.{name}" for name in others)


COLLECTING = """
import gc, sys
from tactfix.cli import COLLECT_AFTER, main
before = gc.get_threshold()
main(["--version"])
assert (gc.get_threshold(), gc.get_freeze_count()) == (before, 0)
sys.argv = ["tactfix", "--version"]
main()
assert gc.get_threshold()[0] == COLLECT_AFTER
assert gc.get_freeze_count() > 0
"""


def test_the_process_of_a_command_looks_for_garbage_seldom_and_no_caller_of_main_does() -> None:
    subprocess.run([sys.executable, "-c", COLLECTING], check=True, capture_output=True)


def test_plain_options_import_no_more() -> None:
    every = [("--json",), ("--quiet",), ("--max-sigma", "1", "--at=0,0,0")]
    lines = [(("locate", *PAPER, *options), {}) for options in every]
    for options, modules in zip(every, imported_by_each(lines), strict=True):
        assert "numpy" in modules
        assert modules.isdisjoint({"pydantic", "rich", "scipy", "tactfix.pose_formats"}), options


@pytest.mark.parametrize(
    ("line", "word", "expected"),
    [
        ("tactfix pl", 1, ["plan"]),
        ("tactfix locate --max", 2, ["--max-sigma", "--max-rms"]),
        ("tactfix fit cy", 2, ["cylinder"]),
        ("tactfix locate f.yaml c.csv --format ku", 5, ["kuka"]),
        ("tactfix locate f.yaml c.csv --contacts-format g", 5, ["grbl"]),
        ("tactfix locate f.yaml c.csv --units m", 5, ["mm", "m"]),
        ("tactfix locate fixtures/three-planes.yaml c.csv --features top:3,b", 5, ["top:3,back:"]),
        ("tactfix locate nowhere.yaml c.csv --features b", 5, []),
        (
            "tactfix simulate fixtures/three-planes.yaml --fault reversed-approach",
            4,
            ["reversed-approaches", "reversed-approach"],
        ),
        ("tactfix locate --explain tip_", 3, ["tip_radius", "tip_offset"]),
        ("tactfix design-check --explain symmetry_o", 3, ["symmetry_overlap"]),
        ("tactfix convert pose.txt --to ku", 4, ["kuka"]),
        ("tactfix convert pose.txt --from hei", 4, ["heidenhain"]),
        ("tactfix report f.yaml c.csv --format ku", 5, ["kuka"]),
        ("tactfix fit sphere samples/robot-cell-plate/contacts.csv --feature b", 5, ["ball"]),
        ("tactfix calibrate samples/robot-calibration/cell.yaml t.csv --hold-out fr", 5, ["front"]),
        ("tactfix locate f.yaml c.csv --free x,r", 5, ["x,rx", "x,ry", "x,rz"]),
        ("tactfix locate f.yaml c.csv --repeats l", 5, ["last"]),
        ("tactfix compare a.json b.json --units i", 5, ["in"]),
        ("tactfix init --like ro", 3, ["robot-cell-plate"]),
    ],
)
def test_completion(line: str, word: int, expected: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    for name, value in completing(line, word).items():
        monkeypatch.setenv(name, value)
    done = tactfix()
    assert done.stdout.split() == expected
    assert done.stderr == ""


def test_no_command_and_a_wrong_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 2
    assert main(["locat"]) == 2
    assert "locate" in capsys.readouterr().err


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("error", "status"),
    [
        (UsageError("not together"), 2),
        (FileError("x.yaml", [Problem("wrong", "mend it")]), 3),
        (MissingExtraError("html", "report"), 3),
        (DegenerateContactsError("cylinder", "collinear", 1e-9, 1e-6, "spread them"), 4),
        (ZeroDivisionError("two\nlines"), 70),
        (KeyboardInterrupt(), 130),
    ],
)
def test_the_exit_status_of_an_error(
    error: BaseException, status: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def locate(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(LOCATING, "locate", locate)
    assert main(RUN) == status
    out, err = capsys.readouterr()
    assert out == ""
    assert "Traceback" not in err
    if isinstance(error, ZeroDivisionError):
        assert err.startswith("tactfix: a bug in tactfix: ZeroDivisionError: two lines; ")
        assert len(err.splitlines()) == 1
        monkeypatch.setenv("TACTFIX_DEBUG", "1")
        with pytest.raises(ZeroDivisionError):
            main(RUN)


@pytest.mark.usefixtures("folder")
def test_a_closed_pipe_is_no_error(answers: Callable[[str], None], monkeypatch: pytest.MonkeyPatch) -> None:
    script = "import sys; from tactfix.cli import main; sys.exit(main())"
    with subprocess.Popen(
        [sys.executable, "-c", script, "schema"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        complaint = process.stderr.read()
    assert complaint == b""
    assert process.returncode == 141


def test_no_color_if_disabled(
    answers: Callable[[str], None], folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    answers("located")
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.delenv("NO_COLOR", raising=False)
    main([*RUN, "--verbose"])
    assert "\x1b[1;32m" in capsys.readouterr().err
    monkeypatch.setenv("NO_COLOR", "1")
    main([*RUN, "--verbose"])
    assert "\x1b[32m" not in capsys.readouterr().err
    assert folder.exists()


def test_the_schema_is_json(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["schema"]) == 0
    text = capsys.readouterr().out
    assert json.loads(text)["properties"]["tactfix"]["const"] == 1
    assert main(["schema", "--output", str(tmp_path / "s.json")]) == 0
    assert (tmp_path / "s.json").read_text(encoding="utf-8") == text
