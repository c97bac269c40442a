"""Draw the pictures in the pages (needs Chromium).

python -m tests.support.picture scene PICTURE.png        the plate of README.md at the pose of its sample
python -m tests.support.picture chart PICTURE.png        the last chart of samples/calibration-day.md
"""

import base64
import contextlib
import doctest
import sys
import tempfile
from pathlib import Path

from tactfix.cli.app import run
from tests.api.pages import ROOT, blocks, folder_for_examples
from tests.support.browser import chromium

NAME = "robot-cell-plate"
SCENE_SIZE = "{format: 'png', width: 1000, height: 560, scale: 1.5}"
CHART_SIZE = "{format: 'png', width: 800, height: 380, scale: 1.5}"
# The picture explains its arrows, because a line at a contact is not obviously the approach.
ANNOTATION_STYLE = (
    "showarrow: true, arrowhead: 2, arrowcolor: '#444', font: {size: 15, color: '#222'}, bgcolor: '#ffffffcc'"
)
LABELS = """
(() => {
  const scene = document.getElementById('scene');
  const way = scene.data.find(t => t.mode === 'lines' && t.legendgroup === 'contacts ball' && t.x.length > 2);
  const frame = scene.data.filter(t => t.legendgroup === 'fixture frame');
  const at = (k, text, ax, ay) => ({
    x: (way.x[k] + way.x[k + 1]) / 2, y: (way.y[k] + way.y[k + 1]) / 2, z: (way.z[k] + way.z[k + 1]) / 2,
    text, ax, ay, ANNOTATION_STYLE});
  const origin = {x: frame[0].x[0], y: frame[0].y[0], z: frame[0].z[0],
    text: 'where is the fixture frame?', ax: -120, ay: 50, ANNOTATION_STYLE};
  const last = way.x.length - 3;
  const notes = [at(last, 'approach: the way that<br>the probe came', 120, -50), origin];
  const camera = {eye: {x: 1.45, y: -1.45, z: 1.0}, center: {x: 0.05, y: 0.05, z: -0.25}};
  return Plotly.relayout(scene, {
    'scene.annotations': notes, 'scene.camera': camera, showlegend: true, width: 1000, height: 560}).then(() => true);
})()
""".replace("ANNOTATION_STYLE", ANNOTATION_STYLE)


def draw_scene(picture: Path) -> None:
    """The scene of the report on the robot cell's sample, with labels at an approach and at the frame."""
    fixture, contacts = f"fixtures/{NAME}.yaml", f"samples/{NAME}/contacts.csv"
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        page = Path(folder) / "page.html"
        run(["report", str(ROOT / fixture), str(ROOT / contacts), "--output", str(page), "--quiet"])
        save(page, LABELS, "scene", SCENE_SIZE, picture)


def draw_chart(picture: Path) -> None:
    """The variable `chart` after the Python blocks of the page have run."""
    page = ROOT / "samples" / "calibration-day.md"
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder, contextlib.chdir(folder):
        folder_for_examples(page, Path(folder))
        names: dict[str, object] = {}
        example = doctest.DocTestParser().get_doctest("\n".join(blocks(page, "python")), names, "", None, 0)
        doctest.DocTestRunner().run(example, clear_globs=False)
        html = example.globs["chart"].to_html(div_id="chart")  # type: ignore[attr-defined]
        Path("chart.html").write_text(html.replace("<html>", '<html data-drawn="yes">'))
        save(Path(folder) / "chart.html", "document.readyState", "chart", CHART_SIZE, picture)


def save(page: Path, prepare: str, element: str, size: str, picture: Path) -> None:
    """Save the plotly figure in this element of a page as a picture, after running this script in the page."""
    with chromium(page.parent / "profile") as tab:
        tab.call("Page.navigate", url=page.as_uri())
        tab.wait_for("document.documentElement?.dataset.drawn === 'yes'")
        tab.run(prepare)
        url = tab.run(f"Plotly.toImage(document.getElementById('{element}'), {size})")
    picture.write_bytes(base64.b64decode(url.partition(",")[2]))


if __name__ == "__main__":
    name, target = sys.argv[1:]
    {"scene": draw_scene, "chart": draw_chart}[name](Path(target).resolve())
