"""Results in a notebook: the summary, and the scene of the HTML report in its own frame."""

import html
import json
import re
import sys
from dataclasses import replace

import numpy as np
import pytest

import tactfix
from tactfix.report.html_calibration import calibration_figure
from tactfix.report.html_design import design_figure
from tactfix.report.html_scene import locate_figure
from tests.support.browser import CHROMIUM, chromium
from tests.support.project import ROOT

PLATE = tactfix.load_fixture(ROOT / "fixtures" / "robot-cell-plate.yaml")
CONTACTS = tactfix.load_contacts(ROOT / "samples" / "robot-cell-plate" / "contacts.csv", PLATE)


def frame(output: str) -> str:
    """The page in the frame of an HTML output."""
    return html.unescape(re.search(r'srcdoc="([^"]*)"', output)[1])


def figure(output: str) -> dict:
    return json.loads(re.search(r'id="figure">(.*?)</script>', frame(output), re.DOTALL)[1])


@pytest.mark.parametrize(
    "contacts",
    [CONTACTS, CONTACTS.on("plate"), replace(CONTACTS, approaches=-CONTACTS.approaches)],
    ids=["located", "underdetermined", "inconsistent"],
)
def test_a_result_shows_its_summary_and_the_scene_of_the_report(contacts):
    result = tactfix.locate(PLATE, contacts)
    output = result._repr_html_()
    assert result.status in output.partition("<iframe")[0]
    assert figure(output) == json.loads(json.dumps(locate_figure(PLATE, contacts, result)))


def test_other_results_with_a_scene_show_it():
    report = tactfix.design_check(PLATE, None, tactfix.Wishes(layouts=0))
    cell = tactfix.load_cell(ROOT / "samples" / "robot-calibration" / "cell.yaml")
    touches = tactfix.load_touches(ROOT / "samples" / "robot-calibration" / "touches.csv", cell)
    calibration = tactfix.calibrate(cell, touches)
    assert figure(report._repr_html_()) == json.loads(json.dumps(design_figure(report)))
    assert figure(calibration._repr_html_()) == json.loads(json.dumps(calibration_figure(calibration)))


def test_a_fit_shows_the_rows_that_it_was_fitted_to():
    output = tactfix.fit("sphere", CONTACTS.on("ball"), radius=19.05)._repr_html_()
    assert "<iframe" not in output
    rows = re.findall(r"^ +(\d+)  ball ", output, re.MULTILINE)
    assert rows == ["11", "12", "13", "14", "15"]


def test_a_result_from_json_explains_the_missing_scene():
    output = tactfix.LocateResult.from_json(tactfix.locate(PLATE, CONTACTS).to_json())._repr_html_()
    assert "<iframe" not in output
    assert "read from JSON" in output
    assert "1184.194" in output


def test_without_the_extra_the_summary_is_left(monkeypatch):
    monkeypatch.setitem(sys.modules, "plotly.offline", None)
    output = tactfix.locate(PLATE, CONTACTS)._repr_html_()
    assert "<iframe" not in output
    assert "pip install" in output
    assert "1184.194" in output


def test_the_scene_has_the_tip_that_was_found():
    """With an unknown tip radius the contacts are drawn on the surfaces, by the radius that was found."""
    result = tactfix.locate(PLATE, CONTACTS, unknown=["tip-radius"])
    drawn = figure(result._repr_html_())
    points = next(trace for trace in drawn["data"] if trace["name"] == "contacts on ball")
    off = np.array([points[axis] for axis in "xyz"]).T - result.surfaces["ball"].center
    residuals = [contact.residual for contact in result.contacts if contact.feature == "ball"]
    # Distance from the centre: the ball's radius plus the residual.
    assert np.linalg.norm(off, axis=1) == pytest.approx(19.05 + np.array(residuals), abs=1e-6)


def test_names_cannot_leave_the_frame():
    """Names come from files: they must be escaped everywhere in the page."""
    evil = '"></iframe><script>alert(1)</script>'
    result = replace(tactfix.locate(PLATE, CONTACTS), fixture=evil, warnings=(evil,))
    assert "<script>alert" not in result._repr_html_()


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here")
def test_the_scene_draws_in_a_page_without_changing_it(tmp_path):
    notebook = tmp_path / "notebook.html"
    output = tactfix.locate(PLATE, CONTACTS)._repr_html_()
    notebook.write_text(f'<!DOCTYPE html><meta charset="utf-8"><h2>cell</h2><div>{output}</div>', encoding="utf-8")
    heading = "JSON.stringify(Object.entries(getComputedStyle(document.querySelector('h2'))))"
    with chromium(tmp_path / "profile") as tab:
        tab.call("Page.navigate", url=notebook.as_uri())
        tab.wait_for("document.readyState === 'complete' && !!document.querySelector('iframe')")
        inner = "document.querySelector('iframe').contentDocument"
        before = tab.run(heading)
        tab.wait_for(f"{inner}.documentElement.dataset.drawn === 'yes'", seconds=180)
        assert tab.run(f"{inner}.querySelectorAll('#scene canvas').length") >= 1
        assert tab.run(heading) == before
        assert tab.run("typeof Plotly") == "undefined"
        assert [url for url in tab.requests if not url.startswith(("data:", "blob:", "about:"))] == [notebook.as_uri()]
        assert tab.errors == []
