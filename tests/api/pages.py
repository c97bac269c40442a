"""The pages of the project: their examples, and the output that the examples have now.

python tests/api/pages.py        rewrites the output of the console examples in the pages

The console blocks of a page are run in order, in one folder. The folder has copies of fixtures/ and samples/, and the
fixture files that the page shows, each under the name that the page gives it.
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
    """The code blocks of a page in this language, without their indentation; also those inside lists."""
    found = ANY_BLOCK.findall(page.read_text(encoding="utf-8"))
    return [textwrap.dedent(text) for _, name, text in found if name == language]


def commands(block: str) -> list[str]:
    """The commands of a console block; a backslash continues a command on the next line."""
    return [line.removeprefix("$ ") for line in block.replace("\\\n", "").splitlines() if line.startswith("$ ")]


def folder_for_examples(page: Path, folder: Path) -> Path:
    """A folder with the files that the examples of a page need, in which they may write."""
    for name in ("fixtures", "samples"):
        shutil.copytree(ROOT / name, folder / name)
    for text in blocks(page, "yaml"):
        name = re.search(r"^name: (\S+)$", text, re.MULTILINE)
        assert name, f"{page}: a fixture without a name"
        (folder / f"{name[1]}.yaml").write_text(text, encoding="utf-8")
    return folder


def environment() -> dict[str, str]:
    """The environment of the examples: the tactfix of this Python on the path, a plain terminal of 100 columns."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    return {"PATH": path, "NO_COLOR": "1", "COLUMNS": "100"}


def outputs(block: str, folder: Path) -> list[str]:
    """The output of each command of a block, run in this folder: standard output and standard error together."""
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
    """The output that the page shows below each command of a block."""
    parts = re.split(r"^\$ (?:.*\\\n)*.*\n", block, flags=re.MULTILINE)
    return parts[1:]


def write_outputs(page: Path) -> None:
    """Replace the output of the console examples in a page by their present output."""
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
