"""Results in a notebook: the summary of the terminal, and below it the scene of the HTML report.

The scene has its own iframe, so that its styles and script do not affect the notebook. Nothing is loaded from the
network: plotly's script comes with each scene, compressed. A viewer without iframes shows the text alone.
"""

import gzip
from base64 import b64encode
from collections.abc import Mapping
from functools import cache
from html import escape
from io import StringIO
from typing import Any, Final

import numpy as np
from rich.console import Console, RenderableType
from rich.terminal_theme import TerminalTheme

from tactfix.contacts import Contacts
from tactfix.errors import MissingExtraError
from tactfix.locate_result import LocateResult
from tactfix.report.html_page import finite, templates_and_plotly
from tactfix.report.html_scene import locate_figure
from tactfix.report.summary import summary

_TEXT_WIDTH: Final = 100
"""Characters of a line: the width of a notebook cell on a laptop."""
_TEXT: Final = "<pre style='line-height:1.2;white-space:pre;overflow-x:auto'><code>{code}</code></pre>"
_FRAME: Final = '<iframe title="scene" srcdoc="{page}" style="width:100%;height:30rem;border:1px solid #8888"></iframe>'
_COLORS: Final = TerminalTheme(
    (255, 255, 255),
    (0, 0, 0),
    [
        (0, 0, 0),
        (217, 83, 79),
        (46, 158, 79),
        (184, 134, 11),
        (70, 130, 220),
        (176, 92, 197),
        (29, 154, 166),
        (127,) * 3,
    ],
)
"""Black, red, green, yellow, blue, magenta, cyan, grey: of middle brightness, to be read on white and on black."""
_FROM_JSON: Final = "This result was read from JSON, which contains no contacts: there is no scene."
_WITHOUT_EXTRA: Final = "The scene needs the extra 'report'; in the folder of tactfix: pip install '.[report]'"


def located_html(result: LocateResult) -> str:
    """The summary of a locate, and its scene."""
    if result.touched is None:
        return text_html(summary(result)) + _note(_FROM_JSON)
    fixture, contacts = result.touched.fixture, _with_the_tip_found(result.touched.contacts, result)
    return text_html(summary(result)) + scene_html(locate_figure(fixture, contacts, result))


def text_html(shown: RenderableType) -> str:
    """The HTML of a rich renderable, with inline styles."""
    console = Console(file=StringIO(), record=True, width=_TEXT_WIDTH, highlight=False)
    console.print(shown)
    return console.export_html(theme=_COLORS, inline_styles=True, code_format=_TEXT)


def _note(sentence: str) -> str:
    return f"<p>{escape(sentence)}</p>"


def scene_html(figure: Mapping[str, Any]) -> str:
    """The figure in an iframe; without the extra, a hint how to install it."""
    try:
        environment, plotly_script = templates_and_plotly()
    except MissingExtraError:
        return _note(_WITHOUT_EXTRA)
    page = environment.get_template("notebook.html.j2").render(
        figure=finite(figure), packed_script=_packed(plotly_script)
    )
    return _FRAME.format(page=escape(page))


@cache
def _packed(script: str) -> str:
    """A script compressed by gzip, as base64 text."""
    return b64encode(gzip.compress(script.encode(), mtime=0)).decode()


def _with_the_tip_found(contacts: Contacts, result: LocateResult) -> Contacts:
    """The contacts corrected for the tip that was estimated with the pose."""
    tip = result.tip
    if tip is None:
        return contacts
    if tip.offset is None or contacts.flange_rotations is None:
        return contacts.with_tip(np.zeros(3), tip.radius)
    before = np.zeros(3) if contacts.tip_offset is None else contacts.tip_offset
    return contacts.with_tip(tip.offset - before, tip.radius)
