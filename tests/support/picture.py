"""Draw the picture of README.md: python -m tests.support.picture FIXTURE PICTURE.png (needs Chromium)."""

import base64
import sys
import tempfile
from pathlib import Path

from tactfix.cli.app import run
from tests.support.browser import chromium

SIZE = "{format: 'png', width: 1000, height: 560}"
EYE = "{'scene.camera.eye': {x: 1.3, y: -1.6, z: 1.1}, showlegend: true}"
SCENE = "document.getElementById('scene')"


def draw(fixture: str, picture: str) -> None:
    """Simulated contacts on the fixture as it stands in its own frame, and where they say that it is."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        pose, contacts, page = (Path(folder) / name for name in ("pose.csv", "contacts.csv", "page.html"))
        pose.write_text("1,0,0,0\n0,1,0,0\n0,0,1,0\n0,0,0,1\n")
        run(["simulate", fixture, "--pose", str(pose), "--seed", "2", "--output", str(contacts)])
        run(["report", fixture, str(contacts), "--output", str(page), "--quiet"])
        with chromium(Path(folder) / "profile") as tab:
            tab.call("Page.navigate", url=page.as_uri())
            tab.wait_for("document.documentElement?.dataset.drawn === 'yes'")
            tab.run(f"Plotly.relayout({SCENE}, {EYE}).then(() => true)")
            url = tab.run(f"Plotly.toImage({SCENE}, {SIZE})")
    Path(picture).write_bytes(base64.b64decode(url.partition(",")[2]))


if __name__ == "__main__":
    draw(*sys.argv[1:])
