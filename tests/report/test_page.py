"""The HTML report: its content, and that names from files cannot inject markup."""

import hashlib
import json
import re
import sys
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from importlib import import_module

import numpy as np
import pytest

from tactfix.cli.app import run
from tactfix.design.design_report import Wishes
from tactfix.errors import MissingExtraError
from tactfix.files.contact_source import load_contacts
from tactfix.files.fixture_file import load_fixture
from tactfix.localization.locate import locate
from tactfix.report.html_page import InputFile, Record, locate_page
from tactfix.report.html_scene import ELLIPSOID_SIGMAS, magnification
from tests.support.project import PLATE_FILE, ROOT

WHEN = datetime(2024, 2, 3, 4, 5, 6, tzinfo=UTC)


@pytest.fixture(scope="module")
def located(contacts_file):
    fixture = load_fixture(PLATE_FILE)
    contacts = load_contacts(contacts_file, fixture)
    return fixture, contacts, locate(fixture, contacts)


def page_of(fixture, contacts, result, inputs=(), settings=None):
    return locate_page(Record(fixture, list(inputs), settings or {}, WHEN), contacts, result)


def figure_of(page):
    return json.loads(re.search(r'id="figure">(.*?)</script>', page, re.DOTALL).group(1))


def test_the_command_writes_a_record(contacts_file, tmp_path, capsys):
    out = tmp_path / "report.html"
    assert run(["report", str(PLATE_FILE), str(contacts_file), "--output", str(out), "--sigma", "0.08"]) == 0
    page = out.read_text()
    for path in (PLATE_FILE, contacts_file):
        assert hashlib.sha256(path.read_bytes()).hexdigest() in page
        assert path.name in page
    assert "x_base = R x_fixture + t" in page
    assert "pointing into the material" in page
    assert "--sigma" in page
    assert run(["locate", str(PLATE_FILE), str(contacts_file), "--sigma", "0.08"]) == 0
    for number in capsys.readouterr().out.split():
        assert number in page
    assert capsys.readouterr().out == ""


def test_a_record_needs_files(contacts_file, tmp_path):
    assert run(["report", str(PLATE_FILE), "-"]) == 2
    assert run(["report", str(PLATE_FILE), str(tmp_path / "none.csv")]) == 3


def test_eliminated_candidates_state_their_reasons(tmp_path):
    fixture = load_fixture(ROOT / "fixtures" / "cylinder-sphere.yaml")
    path = tmp_path / "contacts.csv"
    assert run(["simulate", str(ROOT / "fixtures" / "cylinder-sphere.yaml"), "--seed", "1", "--output", str(path)]) == 0
    contacts = load_contacts(path, fixture)
    result = locate(fixture, contacts)
    fallen = [candidate for candidate in result.candidates if not candidate.accepted]
    assert fallen, "this fixture always leaves a second pose to fall"
    page = page_of(fixture, contacts, result)
    assert f"{fallen[0].reasons[0].code}: " in page
    assert "(rejected)" in page
    assert 'badge located"' in page


def test_a_result_without_a_pose_has_a_page_too(located):
    fixture, contacts, _ = located
    few = contacts.subset([i for i, name in enumerate(contacts.features) if name == "pin"])
    result = locate(fixture, few)
    assert result.status == "underdetermined"
    page = page_of(fixture, few, result)
    assert "base_from_fixture (mm)" not in page
    assert "Free: " in page
    odd = replace(result, candidates=(), surfaces={}, contacts=(), status="inconsistent")
    assert "inconsistent" in page_of(fixture, few, odd)


def test_contacts_and_surfaces_are_where_they_should_be(located):
    fixture, contacts, result = located
    drawn = figure_of(page_of(fixture, contacts, result))["data"]
    traces = {trace["name"]: trace for trace in drawn if trace.get("mode") != "lines"}
    rotation, origin = result.base_from_fixture[:3, :3], result.base_from_fixture[:3, 3]

    def at_home(trace):
        return (np.stack([np.array(trace[k], dtype=float) for k in "xyz"], axis=-1) - origin) @ rotation

    ball, pin, plate = (at_home(traces[name]) for name in ("ball", "pin", "plate"))
    np.testing.assert_allclose(np.linalg.norm(ball - [300, 180, 60], axis=-1), 19.05, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(pin[..., :2], axis=-1), 10, atol=1e-9)
    assert pin[..., 2].min() == pytest.approx(-4, abs=12)
    assert pin[..., 2].max() == pytest.approx(46, abs=12)
    np.testing.assert_allclose(plate[..., 2], 0, atol=1e-9)
    assert plate[..., 0].min() == pytest.approx(-40)
    assert plate[..., 0].max() == pytest.approx(340)
    touched = at_home(traces["contacts on ball"])
    assert (
        np.abs(np.linalg.norm(touched - [300, 180, 60], axis=-1) - 19.05).max() < 0.4
    )  # five sigma of a robot's contacts
    assert set(traces) >= {"plate", "pin", "ball", "contacts on plate", "fixture frame"}


def test_the_ellipsoid_is_the_covariance_times_the_stated_factor(located):
    fixture, contacts, result = located
    (trace,) = (t for t in figure_of(page_of(fixture, contacts, result))["data"] if "95 %" in t.get("name", ""))
    factor = float(re.search(r"([\d.e+-]+) times larger", trace["name"]).group(1))
    points = np.stack([np.array(trace[k]) for k in "xyz"], axis=-1).reshape(-1, 3) - result.base_from_fixture[:3, 3]
    inverse = np.linalg.inv(result.covariance[3:, 3:])
    distance = np.sqrt(np.einsum("ki,ij,kj->k", points, inverse, points)) / factor
    np.testing.assert_allclose(distance, np.sqrt(7.8147), rtol=1e-3)  # chi-square, 3 degrees of freedom, 95 per cent
    assert np.sqrt(7.8147) == pytest.approx(ELLIPSOID_SIGMAS, rel=1e-4)
    assert magnification(0 * result.covariance, 100.0) == 1.0


def test_hostile_names_stay_text(located):
    fixture, contacts, result = located
    bad = "</script><script>alert(1)</script>"
    evil = replace(result, fixture=bad, warnings=(bad,))
    page = page_of(fixture, contacts, evil, [InputFile("fixture", bad, bad.encode())], {bad: bad})
    assert bad not in page
    assert "&lt;/script&gt;" in page


def test_the_page_asks_nobody_for_anything(located):
    page = page_of(*located)
    assert "default-src 'none'" in page
    assert not re.search(r"""<(script|link|img|iframe)[^>]+(src|href)=["']?(https?:)?//""", page)


def test_without_the_extra_the_message_names_it(located, monkeypatch):
    monkeypatch.setitem(sys.modules, "plotly.offline", None)
    with pytest.raises(MissingExtraError, match=r"pip install '\.\[report\]'"):
        page_of(*located)


@pytest.mark.parametrize(
    ("name", "layouts", "options"),
    [
        ("robot-cell-plate", Wishes().layouts, ["--sigma", "0.01", "--tip-radius", "1"]),
        ("cylinder-sphere", 2, []),
        pytest.param("three-spheres", 2, [], marks=pytest.mark.slow),
    ],
)
def test_a_design_has_a_record_too(name, layouts, options, tmp_path, monkeypatch):
    # The study of random layouts is tested elsewhere.
    import_module("tactfix.design.design_check")  # before Wishes is replaced, because annotations need the class
    monkeypatch.setattr(sys.modules["tactfix.design.design_report"], "Wishes", partial(Wishes, layouts=layouts))
    path, out = ROOT / "fixtures" / f"{name}.yaml", tmp_path / "design.html"
    status = run(["report", str(path), "--output", str(out), *options])
    page = out.read_text()
    assert status == (1 if 'badge error">error</span></h1>' in page else 0)
    assert hashlib.sha256(path.read_bytes()).hexdigest() in page
    names = {trace["name"] for trace in figure_of(page)["data"]}
    assert set(load_fixture(path).features) <= names
    assert "x_base = R x_fixture + t" in page
    assert run(["report", str(path), "--features", "a:1"]) == 2


def test_notes_are_part_of_the_record(contacts_file, tmp_path, capsys):
    out = tmp_path / "report.html"
    line = [
        "report",
        str(PLATE_FILE),
        str(contacts_file),
        "--output",
        str(out),
        "--format",
        "kuka",
        "--at",
        "300,180,60",
    ]
    notes = ["--note", "operator=Ada L.", "--note", "machine=cell 3"]
    assert run([*line, *notes, "--max-sigma", "0.0001"]) == 1
    page = out.read_text()
    assert "operator" in page
    assert "Ada L." in page
    assert "cell 3" in page
    assert "not acceptable: the worst sigma" in page
    assert "{X " in page
    assert "0.08 mm" in page
    assert "sigma at 300, 180, 60 of the fixture" in page
    assert "not acceptable" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["report.docx", "report", "report.pdf.zip"])
def test_an_ending_that_cannot_be_written_is_refused_before_anything_else(name, tmp_path, capsys):
    out = tmp_path / name
    assert run(["report", "no-such-file.yaml", "no-such.csv", "--output", str(out)]) == 2
    assert ".html, .pdf or .png" in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize("note", ["operator", "=Ada", ""])
def test_a_note_has_a_key_and_a_value(note, contacts_file, capsys):
    assert run(["report", str(PLATE_FILE), str(contacts_file), "--note", note]) == 2
    assert "KEY=VALUE" in capsys.readouterr().err


def test_without_a_browser_the_page_is_offered_instead(contacts_file, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert run(["report", str(PLATE_FILE), str(contacts_file), "--output", str(tmp_path / "report.pdf")]) == 2
    assert "write .html" in capsys.readouterr().err


def test_the_row_that_is_accused_is_marked(tmp_path):
    path = tmp_path / "reversed.csv"
    assert (
        run(["simulate", str(PLATE_FILE), "--seed", "4", "--fault", "reversed-approach:3", "--output", str(path)]) == 0
    )
    fixture = load_fixture(PLATE_FILE)
    contacts = load_contacts(path, fixture)
    result = locate(fixture, contacts)
    assert result.status == "inconsistent"
    page = page_of(fixture, contacts, result)
    assert re.findall(r'<tr class="accused"><td class="n">(\d+)</td>', page) == ["3"]


@pytest.fixture(scope="module")
def ambiguous():
    fixture = load_fixture(ROOT / "fixtures" / "cylinder-sphere.yaml")
    contacts = load_contacts(ROOT / "samples" / "cylinder-sphere" / "contacts-normal.csv", fixture)
    return fixture, contacts, locate(fixture, contacts)


def test_both_poses_of_an_ambiguous_result_are_drawn_distinctly(ambiguous):
    fixture, contacts, result = ambiguous
    page = page_of(fixture, contacts, result)
    shown = [trace for trace in figure_of(page)["data"] if trace.get("visible", True) is True]
    balls = [trace for trace in shown if trace["type"] == "surface" and trace["name"] == "ball"]
    left = [candidate for candidate in result.candidates if candidate.accepted]
    assert len(balls) == len(left) == 2
    for ball, candidate in zip(balls, left, strict=True):
        points = np.stack([np.array(ball[k], dtype=float) for k in "xyz"], axis=-1)
        np.testing.assert_allclose(
            np.linalg.norm(points - candidate.surfaces["ball"].center, axis=-1), candidate.surfaces["ball"].radius
        )
    colors = [ball["colorscale"][0][1] for ball in balls]
    assert len(set(colors)) == 2
    assert all(f"background: {color}" in page for color in colors), "the table has the colours of the scene"
    assert {"pose 1", "pose 2"} <= {trace["name"] for trace in shown if trace.get("showlegend", True)}
    assert sum(trace["name"] == "bar" for trace in shown) == 1, "what both share is drawn once"


def test_the_next_contact_is_marked_in_scene_and_table(ambiguous):
    fixture, contacts, result = ambiguous
    page = page_of(fixture, contacts, result)
    (trace,) = (t for t in figure_of(page)["data"] if t.get("mode") == "markers" and t["name"].startswith("next"))
    np.testing.assert_allclose([trace[k][0] for k in "xyz"], result.next_contact.point)
    assert '<tr class="next"><td>ball</td><td data-name="frame">base</td>' in page


def test_the_accused_contact_is_ringed_in_the_scene(tmp_path):
    path = tmp_path / "outlier.csv"
    assert run(["simulate", str(PLATE_FILE), "--seed", "4", "--fault", "outlier:1", "--output", str(path)]) == 0
    fixture = load_fixture(PLATE_FILE)
    contacts = load_contacts(path, fixture)
    result = locate(fixture, contacts)
    (row,) = result.diagnosis[0].rows
    (ring,) = (
        trace
        for trace in figure_of(page_of(fixture, contacts, result))["data"]
        if trace.get("name") == f"suspect: row {row}"
    )
    center = np.array([ring[k][0] for k in "xyz"])
    assert np.linalg.norm(center - contacts.points[row - 1]) == pytest.approx(contacts.tip_radius)


def test_the_sentence_above_the_signature_fits_the_status(located, ambiguous):
    assert "the pose may be used." in page_of(*located)
    assert "no pose may be used from these contacts." in page_of(*ambiguous)


def test_no_option_is_mentioned_without_options(located, ambiguous):
    for page in (page_of(*located), page_of(*ambiguous)):
        assert "--json" not in page.partition("<script>")[0]


def test_a_design_check_writes_a_page_that_begins_with_the_worst_finding(tmp_path, capsys):
    path, out = ROOT / "fixtures" / "three-planes.yaml", tmp_path / "design.html"
    assert run(["design-check", str(path), "--study", "0", "--tip-radius", "1.5", "--output", str(out)]) == 1
    body = out.read_text().partition("<body>")[2]
    assert body.index("Not fit for use: 1 error and 4 warnings") < body.index("<h2>Findings</h2>")
    badges = re.findall(r'<td><span class="badge (\w+)"', body)
    assert badges == sorted(badges, key=("error", "warning", "ok").index)
    assert "By signing I confirm" in body
    assert hashlib.sha256(path.read_bytes()).hexdigest() in body
    assert "--tip-radius" in body
    assert capsys.readouterr().out == ""
