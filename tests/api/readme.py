"""The examples of the README: what they are, and what they print now.

python tests/api/readme.py        writes the console examples' output anew into README.md
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_END = "-- end of output --"


def blocks(language: str) -> list[str]:
    """The code blocks of the README in this language."""
    return [text for name, text in BLOCK.findall(README.read_text(encoding="utf-8")) if name == language]


def commands(block: str) -> list[str]:
    """The lines of a console block that somebody types; a backslash carries one on."""
    return [line.removeprefix("$ ") for line in block.replace("\\\n", "").splitlines() if line.startswith("$ ")]


def folder_for_examples(path: Path) -> Path:
    """A folder with copies of fixtures/ and samples/, where examples may write."""
    for name in ("fixtures", "samples"):
        shutil.copytree(ROOT / name, path / name)
    return path


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
    """What the README shows below each command of a block."""
    parts = re.split(r"^\$ (?:.*\\\n)*.*\n", block, flags=re.MULTILINE)
    return parts[1:]


def _rewritten(match: re.Match[str]) -> str:
    language, block = match.groups()
    if language != "console":
        return match[0]
    typed = re.findall(r"^\$ (?:.*\\\n)*.*\n", block, flags=re.MULTILINE)
    with tempfile.TemporaryDirectory() as folder:
        printed = outputs(block, folder_for_examples(Path(folder)))
    text = "".join(command + output for command, output in zip(typed, printed, strict=True))
    return f"```console\n{text}```"


if __name__ == "__main__":
    README.write_text(BLOCK.sub(_rewritten, README.read_text(encoding="utf-8")), encoding="utf-8")
