"""The pages are correct: their console and Python examples are run, and commands, options and files listed exist."""

import doctest
import json
import re
import subprocess
from pathlib import Path

import pytest

from tests.api.pages import PAGES, ROOT, blocks, commands, environment, folder_for_examples, shown
from tests.support.command_line import tactfix

NUMBER = re.compile(r"(?<![\w.])[-+]?\d+\.?\d*(?:e[-+]?\d+)?", re.IGNORECASE)
EVERYTHING = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)


def name_of(page: Path) -> str:
    return str(page.relative_to(ROOT))


def assert_alike(printed: str, documented: str) -> None:
    """The same words, and the same numbers except for last digits, which depend on the processor."""
    assert NUMBER.sub("#", printed).split() == NUMBER.sub("#", documented).split()
    ours, theirs = ([float(n) for n in NUMBER.findall(text)] for text in (printed, documented))
    assert ours == pytest.approx(theirs, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, "console")], ids=name_of)
def test_console_examples(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each command is run with the exit status of the preceding one."""
    monkeypatch.chdir(folder_for_examples(page, tmp_path))
    for name, value in environment().items():
        monkeypatch.setenv(name, value)
    for block in blocks(page, "console"):
        status = 0
        for command, documented in zip(commands(block), shown(block), strict=True):
            status, printed = typed(command, status)
            assert_alike(printed, documented)


PLAIN = re.compile(r"tactfix [\w\s./:,-]+")
"""A tactfix command that needs no shell."""


def typed(command: str, status: int) -> tuple[int, str]:
    """Exit status and output of a command; run in this process if it needs no shell. status: of the command before."""
    first, pipe, rest = command.partition(" | ")
    if not PLAIN.fullmatch(first):
        return in_shell(f"(exit {status}); {command}", "")
    done = tactfix(*first.split()[1:], together=not pipe)
    if not pipe:
        return done.returncode, done.stdout
    status, printed = in_shell(rest, done.stdout)
    return status, done.stderr + printed


def in_shell(command: str, given: str) -> tuple[int, str]:
    """Exit status and output (with standard error) of a shell that reads this text from standard input."""
    bash = ["bash", "-c", command]
    done = subprocess.run(bash, input=given, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    return done.returncode, done.stdout


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, "python")], ids=name_of)
def test_python_examples(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder_for_examples(page, tmp_path))
    text = "\n".join(blocks(page, "python"))
    example = doctest.DocTestParser().get_doctest(text, {}, name_of(page), str(page), 0)
    assert example.examples
    output: list[str] = []
    failed, _ = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example, out=output.append)
    assert not failed, "".join(output)


def test_the_fixture_of_the_paper_is_the_one_that_is_shipped() -> None:
    shipped = (ROOT / "fixtures" / "cylinder-sphere.yaml").read_text(encoding="utf-8")
    assert any(text in shipped for text in blocks(ROOT / "fixtures" / "README.md", "yaml"))


def test_the_json_of_the_pages_has_the_keys_that_are_written(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = {
        "tactfix/locate/1": "locate fixtures/cylinder-sphere.yaml samples/cylinder-sphere/contacts.csv --json",
        "tactfix/fit/1": "fit plane samples/three-planes/contacts.csv --feature top --json",
        "tactfix/design-check/1": "design-check fixtures/three-planes.yaml --json --study 0",
    }
    monkeypatch.chdir(ROOT)
    json_blocks = [block for page in PAGES for block in blocks(page, "jsonc")]
    assert len(json_blocks) >= len(calls)
    for block in json_blocks:
        schema = re.search(r'"schema": "([^"]+)"', block)
        assert schema
        printed = tactfix(*calls[schema[1]].split()).stdout
        assert keys_of(block) == set(json.loads(printed)), schema[1]


def keys_of(block: str) -> set[str]:
    """The keys of the outermost object, without comments and nested values."""
    text = re.sub(r"//.*", "", block).strip().removeprefix("{").removesuffix("}")
    while (flat := re.sub(r"\{[^{}]*\}|\[[^\[\]]*\]", "", text)) != text:
        text = flat
    return set(re.findall(r'"(\w+)":', text))


def test_every_command_and_format_is_documented() -> None:
    from tactfix.cli.application import COMMANDS
    from tactfix.files.logs import LOG_FORMATS
    from tactfix.pose_formats import DIALECTS

    first = PAGES[0].read_text(encoding="utf-8")
    for name in COMMANDS:
        assert f"`tactfix {name}" in first, name
    for name in (*DIALECTS, *LOG_FORMATS):
        assert f"`{name}`" in EVERYTHING, name


def test_every_option_that_the_pages_name_exists() -> None:
    from tactfix.cli.application import COMMANDS

    helps = "".join(tactfix(command, "--help").stdout for command in COMMANDS)
    known = set(re.findall(r"--[a-z][a-z-]+", helps)) | {"--version", "--install-completion"}
    assert set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", OF_OTHERS.sub("", EVERYTHING))) <= known


OF_OTHERS = re.compile(r"^python3.*$|`mypy --strict`|`python [^`]*`|`pytest [^`]*`|\(`--seed[^`]*`", re.MULTILINE)


def test_every_file_that_the_pages_name_exists() -> None:
    named = set(re.findall(r"\b(?:fixtures|samples|src|tests)/[\w./-]+\w", EVERYTHING))
    assert named
    assert [name for name in sorted(named) if not (ROOT / name).exists()] == []


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_link_leads_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8"))
    assert [link for link in links if not (page.parent / link).exists()] == []
