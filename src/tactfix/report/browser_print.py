"""An HTML page as PDF or PNG, rendered by an installed Chromium; the page itself needs none."""

import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Final

from tactfix.errors import UsageError

_BROWSERS: Final = ("chromium", "chromium-browser", "google-chrome", "chrome", "msedge")
_FLAGS: Final = (
    "--headless",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--virtual-time-budget=20000",
)
"""No network access; the scene is rendered in software, with a virtual time budget (ms) for its scripts."""
_SECONDS: Final = 120
"""Time limit of the browser."""
_WIDTH: Final = 1200
"""Pixels of a picture: the page is at most 72 rem wide, 1152 pixels, and has a margin."""
_HEIGHT: Final = 2200
"""Pixels: default height of a picture, if the page does not give its own."""


def in_form(page: str, suffix: str) -> str | bytes:
    """The page as it is for .html, printed for .pdf, as a picture for .png.

    Raises UsageError if no browser is found or printing fails.
    """
    if suffix in (".html", ".htm"):
        return page
    browser = next(filter(None, map(shutil.which, _BROWSERS)), None)
    if browser is None:
        raise UsageError(f"a report as {suffix} is printed by Chromium, and none is found; install it, or write .html")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        return _printed(browser, Path(folder), page, suffix)


def _printed(browser: str, folder: Path, page: str, suffix: str) -> bytes:
    source, target = folder / "page.html", folder / f"page{suffix}"
    source.write_text(page, encoding="utf-8")
    form = ["--no-pdf-header-footer", f"--print-to-pdf={target}"]
    if suffix == ".png":
        # A screenshot has the height of its window, so the page's height is read first.
        drawn = _run(browser, folder, [f"--window-size={_WIDTH},{_HEIGHT}", "--dump-dom", source.as_uri()])
        height = re.search(rb'data-height="(\d+)"', drawn.stdout)
        form = [f"--window-size={_WIDTH},{int(height[1]) if height else _HEIGHT}", f"--screenshot={target}"]
    done = _run(browser, folder, [*form, source.as_uri()])
    if not target.exists():
        raise UsageError(f"{browser} has not printed the report (exit status {done.returncode}); write .html instead")
    return target.read_bytes()


def _run(browser: str, folder: Path, arguments: list[str]) -> subprocess.CompletedProcess[bytes]:
    # Run as root in a container, Chromium cannot use its sandbox; the page is generated here and loads nothing.
    command = [browser, *_FLAGS, "--no-sandbox", f"--user-data-dir={folder / 'profile'}", *arguments]
    try:
        return subprocess.run(command, capture_output=True, timeout=_SECONDS, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise UsageError(f"{browser} does not print the report ({error}); write .html instead") from None
