"""The pages of the project and their examples: what they are, and what they print now.

python tests/api/pages.py        writes the output of the console examples anew into the pages

A page is one session: its console blocks are run in order, in one folder. It has copies of fixtures/ and samples/, and
the fixture files that the page writes out, by the name that each gives itself.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import textwrap
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = (
    *(ROOT / folder / "README.md" for folder in ("", "fixtures", "samples", "src/tactfix", "tests")),
    ROOT / "samples" / "calibration-day.md",
)
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
ANY_BLOCK = re.compile(r"^( *)```(\w+)\n(.*?)^\1```$", re.MULTILINE | re.DOTALL)
_END = "-- end of output --"


def blocks(page: Path, language: str) -> list[str]:
    """The code blocks of a page in this language, those inside lists too, without their indent."""
    found = ANY_BLOCK.findall(page.read_text(encoding="utf-8"))
    return [textwrap.dedent(text) for _, name, text in found if name == language]


def commands(block: str) -> list[str]:
    """The lines of a console block that somebody types; a backslash carries one on."""
    return [line.removeprefix("$ ") for line in block.replace("\\\n", "").splitlines() if line.startswith("$ ")]


def folder_for_examples(page: Path, folder: Path) -> Path:
    """The folder with what the examples of a page need, where they may write."""
    for name in ("fixtures", "samples"):
        shutil.copytree(ROOT / name, folder / name)
    for text in blocks(page, "yaml"):
        name = re.search(r"^name: (\S+)$", text, re.MULTILINE)
        assert name, f"{page}: a fixture without a name"
        (folder / f"{name[1]}.yaml").write_text(text, encoding="utf-8")
    return folder


def environment() -> dict[str, str]:
    """What is set where examples are run: the tactfix of this Python on the path, a plain terminal 100 wide."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    return {"PATH": path, "NO_COLOR": "1", "COLUMNS": "100"}


def outputs(block: str, folder: Path) -> list[str]:
    """What each command of a block prints, standard output and standard error together, run in this folder."""
    script = "".join(f"{command}\nstatus=$?; echo '{_END}'; (exit $status)\n" for command in commands(block))
    done = subprocess.run(
        ["bash", "-c", script],
        cwd=folder,
        env={**os.environ, **environment()},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    return done.stdout.split(f"{_END}\n")[:-1]


def shown(block: str) -> list[str]:
    """What the page shows below each command of a block."""
    parts = re.split(r"^\$ (?:.*\\\n)*.*\n", block, flags=re.MULTILINE)
    return parts[1:]


def write_outputs(page: Path) -> None:
    """Write what the console examples of a page print now into it."""
    with tempfile.TemporaryDirectory() as folder:
        place = folder_for_examples(page, Path(folder))

        def rewritten(match: re.Match[str]) -> str:
            language, block = match.groups()
            if language != "console":
                return match[0]
            typed = re.findall(r"^\$ (?:.*\\\n)*.*\n", block, flags=re.MULTILINE)
            printed = outputs(block, place)
            text = "".join(command + output for command, output in zip(typed, printed, strict=True))
            return f"```console\n{text}```"

        page.write_text(BLOCK.sub(rewritten, page.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    for each in PAGES:
        write_outputs(each)
