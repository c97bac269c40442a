"""The report page in a browser: it draws, the mouse rotates the scene, and the page makes no network request."""

import os

import pytest

from tactfix.cli.app import run
from tests.support.browser import CHROMIUM, chromium
from tests.support.project import PLATE_FILE

# Set by .ci/run, where a missing browser is a failure and not a reason to skip.
NEEDED = os.environ.get("TACTFIX_NEEDS_CHROMIUM") == "1"
pytestmark = pytest.mark.skipif(CHROMIUM is None and not NEEDED, reason="no Chromium here")

CAMERA = "JSON.stringify(document.getElementById('scene')._fullLayout.scene._scene.getCamera().eye)"
PLACE = "document.getElementById('scene').getBoundingClientRect().toJSON()"
COLOURED = """
const size = {format: 'png', width: 600, height: 400};
Plotly.toImage(document.getElementById('scene'), size).then(url => new Promise(done => {
  const image = new Image();
  image.onload = () => {
    const canvas = document.createElement('canvas');
    canvas.width = 600; canvas.height = 400;
    const pen = canvas.getContext('2d');
    pen.drawImage(image, 0, 0);
    // The legend, on the right, is no part of the 3D scene.
    const pixels = pen.getImageData(0, 0, 380, 400).data;
    let count = 0;
    for (let i = 0; i < pixels.length; i += 4) {
      const rgb = [pixels[i], pixels[i + 1], pixels[i + 2]];
      if (pixels[i + 3] > 128 && Math.max(...rgb) - Math.min(...rgb) > 40) count += 1;
    }
    done(count);
  };
  image.src = url;
}))"""


@pytest.fixture(scope="module")
def page(contacts_file, tmp_path_factory):
    out = tmp_path_factory.mktemp("page") / "report.html"
    assert run(["report", str(PLATE_FILE), str(contacts_file), "--output", str(out)]) == 0
    assert CHROMIUM is not None, "TACTFIX_NEEDS_CHROMIUM is set, and there is none: install the package chromium"
    with chromium(tmp_path_factory.mktemp("profile")) as tab:
        tab.call("Page.navigate", url=out.as_uri())
        tab.wait_for("document.documentElement?.dataset.drawn === 'yes'")
        tab.address = out.as_uri()
        yield tab


def test_the_page_draws(page):
    assert page.run(COLOURED) > 2000
    assert page.run("document.querySelectorAll('#scene canvas').length") >= 1
    assert page.run("document.getElementById('scene').textContent.includes('WebGL is not supported')") is False


def test_the_mouse_rotates_the_scene(page):
    place = page.run(PLACE)
    before, looked = page.run(CAMERA), page.screenshot(place)
    middle = (place["x"] + 0.35 * place["width"], place["y"] + 0.5 * place["height"])
    page.drag(middle, (middle[0] + 150, middle[1] + 60))
    page.wait_for(f"{CAMERA} !== {before!r}")
    assert page.screenshot(place) != looked


def test_the_page_makes_no_request(page):
    left = [url for url in page.requests if not url.startswith(("data:", "blob:"))]
    assert left == [page.address]
    assert page.errors == []


def test_no_button_leads_away(page):
    titles = page.run("[...document.querySelectorAll('#scene .modebar-btn')].map(b => b.dataset.title)")
    assert len(titles) == 6
    assert not any(word in title.lower() for title in titles for word in ("share", "link", "cloud", "edit", "logo"))
    assert page.run("document.querySelectorAll('a[href]').length") == 0


def test_the_page_blocks_requests(page):
    # The check above does detect requests: this one is made, and blocked by the page's policy.
    blocked = page.run("fetch('http://127.0.0.1:9/').then(() => 'left', () => 'refused')")
    assert blocked == "refused"
    assert any("Content Security Policy" in error for error in page.errors)


@pytest.mark.parametrize(
    ("ending", "magic"), [(".pdf", b"%PDF-"), pytest.param(".png", b"\x89PNG", marks=pytest.mark.slow)]
)
def test_a_report_is_printed(ending, magic, contacts_file, tmp_path):
    out = tmp_path / f"report{ending}"
    assert run(["report", str(PLATE_FILE), str(contacts_file), "--output", str(out)]) == 0
    assert out.read_bytes().startswith(magic)
    assert out.stat().st_size > 20_000
    if ending == ".png":
        # Width and height are in the header; the inputs at the end of the page are included.
        assert int.from_bytes(out.read_bytes()[20:24], "big") > 2500


def test_a_narrow_page_does_not_scroll_sideways(page):
    page.call("Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=1, mobile=True)
    try:
        page.call("Page.navigate", url=page.address)
        page.wait_for("document.documentElement?.dataset.drawn === 'yes'")
        assert page.run("document.documentElement.scrollWidth") <= 390
        scene, legend = (
            page.run(f"document.querySelector('#scene {name}').getBoundingClientRect().toJSON()")
            for name in (".gl-container canvas, canvas", ".legend")
        )
        assert legend["top"] >= scene["bottom"] - 2
    finally:
        page.call("Emulation.clearDeviceMetricsOverride")


def test_paper_shows_the_scene(page):
    """WebGL content is not printed: a picture in light colours replaces it."""
    page.wait_for("document.getElementById('printed').naturalWidth", seconds=180)
    page.call("Emulation.setEmulatedMedia", media="print")
    try:
        assert page.run("getComputedStyle(document.getElementById('scene')).display") == "none"
        drawn = "(() => { const p = document.getElementById('printed'); return [p.offsetWidth, p.naturalWidth]; })()"
        shown, natural = page.run(drawn)
        assert shown > 500
        assert natural == 1500
    finally:
        page.call("Emulation.setEmulatedMedia", media="")
