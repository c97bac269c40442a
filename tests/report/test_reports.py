"""JSON, text and summary of results: the documented fields, exact doubles, and null for values that are no numbers."""

import io
import json
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from tactfix.fitting.fit import FitCandidate, FitResult
from tactfix.geometry.surfaces import Plane, Sphere
from tactfix.report.json_report import fit_json, locate_json, plain, text_of
from tactfix.report.summary import summary
from tactfix.report.text_report import fit_status_lines, matrix_text, status_lines, surface_text
from tactfix.results import Status
from tactfix.wording import borne
from tests.support.answers import BASE_FROM_FIXTURE, COVARIANCE, HALF_TURN, answer

STATUSES: list[Status] = ["located", "underdetermined", "ambiguous", "inconsistent"]


def back(report: dict[str, Any]) -> dict[str, Any]:
    """A report read by a strict JSON parser."""

    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    parsed: dict[str, Any] = json.loads(text_of(report), parse_constant=refuse)
    return parsed


@pytest.mark.parametrize("status", STATUSES)
def test_the_fields_of_locate(status: Status) -> None:
    report = back(locate_json(answer(status)))
    assert set(report) >= {
        *("schema", "tactfix_version", "fixture", "units", "status", "transform", "covariance", "dof", "chi2", "rms"),
        *("candidates", "features", "contacts", "free_motions", "next_contact", "warnings"),
    }
    assert (report["schema"], report["status"], report["fixture"]) == ("tactfix/locate/1", status, "cell")
    assert (report["transform"] is None) == (report["covariance"] is None) == (status != "located")
    assert (report["next_contact"] is None) == (status != "ambiguous")
    assert bool(report["free_motions"]) == (status == "underdetermined")
    for candidate in report["candidates"]:
        assert set(candidate) == {"transform", "chi2", "rms", "accepted", "reasons"}
        assert candidate["accepted"] == (candidate["reasons"] == [])


def test_the_doubles_of_locate_come_back() -> None:
    report = back(locate_json(answer()))
    np.testing.assert_array_equal(report["transform"], BASE_FROM_FIXTURE)
    np.testing.assert_array_equal(report["covariance"], COVARIANCE)
    np.testing.assert_array_equal(report["candidates"][1]["transform"], HALF_TURN)
    assert report["candidates"][1]["reasons"][0] == {
        "code": "touch",
        "feature": "bar",
        "row": 1,
        "message": "y is -2.3, outside [0.2, 6.0]",
    }
    assert report["features"] == {
        "ball": {"type": "sphere", "center": [1.0, 2.0, 3.0], "radius": 12.7},
        "bar": {"type": "cylinder", "point": [0.0, 0.0, 0.0], "direction": [0.0, 0.0, -1.0], "radius": 1.0},
        "top": {"type": "plane", "point": [0.0, 0.0, 0.0], "normal": [0.0, 0.6, 0.8]},
    }
    assert report["contacts"][1] == {"row": 2, "feature": "bar", "residual": -2e-4 / 3, "approach_angle_deg": None}


def test_zero_has_no_sign() -> None:
    assert "-0.0" not in text_of(locate_json(answer()))
    assert "-0.0 " not in matrix_text(BASE_FROM_FIXTURE)


def test_values_that_are_no_numbers_are_null() -> None:
    assert plain(float("nan")) is None
    assert plain(float("inf")) is None
    assert plain(np.array([[1.0, np.nan], [np.inf, -0.0]])) == [[1.0, None], [None, 0.0]]


def test_the_matrix_is_four_lines_that_numpy_reads_to_the_last_bit() -> None:
    rng = np.random.default_rng(1)
    for matrix in (BASE_FROM_FIXTURE, rng.normal(size=(4, 4)) * 10.0 ** rng.integers(-300, 300, (4, 4))):
        text = matrix_text(matrix)
        assert [len(line.split()) for line in text.splitlines()] == [4] * 4
        np.testing.assert_array_equal(np.loadtxt(io.StringIO(text)), matrix)


def fitted(status: Status) -> FitResult:
    ball = Sphere(np.array([1.0, -0.0, 1 / 3]), 2.0)
    located = status == "located"
    return FitResult(
        kind="sphere",
        status=status,
        dof=0,
        surface=ball if located else None,
        candidates=(FitCandidate(ball, 0.1, 0.01, False),),
        chi2=0.1 if located else None,
        chi2_limit=3.84,
        rms=0.01 if located else None,
        residuals=np.array([0.01, -0.01]) if located else np.zeros(0),
        sigma={"center": np.array([0.1, 0.2, np.nan]), "radius": np.array([0.3])} if located else {},
        warnings=("few contacts",),
        units="m",
    )


def test_the_fields_of_fit() -> None:
    report = back(fit_json(fitted("located")))
    assert set(report) >= {
        "schema",
        "kind",
        "units",
        "status",
        "surface",
        "candidates",
        "rms",
        "residuals",
        "sigma",
        "warnings",
    }
    assert (report["schema"], report["kind"], report["units"]) == ("tactfix/fit/1", "sphere", "m")
    assert report["surface"] == {"type": "sphere", "center": [1.0, 0.0, 1 / 3], "radius": 2.0}
    assert report["sigma"] == {"center": [0.1, 0.2, None], "radius": 0.3}
    assert report["residuals"] == [0.01, -0.01]
    assert back(fit_json(fitted("ambiguous")))["surface"] is None


def test_a_surface_as_text() -> None:
    assert surface_text(Plane(np.zeros(3), np.array([0.0, 0.0, -5.0]))) == "point 0.0 0.0 0.0\nnormal 0.0 0.0 -1.0\n"
    assert surface_text(Sphere(np.array([1 / 3, -0.0, 1.0]), 2.5)) == f"center {1 / 3!r} 0.0 1.0\nradius 2.5\n"


def test_each_status_names_a_remedy() -> None:
    lines = {status: "\n".join(status_lines(answer(status))) for status in STATUSES}
    assert lines["located"] == ""
    assert "turns about the axis of bar" in lines["underdetermined"]
    assert "2 poses" in lines["ambiguous"]
    assert "touch ball from above" in lines["ambiguous"]
    assert "bar, row 1" in lines["inconsistent"]
    for status in STATUSES[1:]:
        assert "\n".join(fit_status_lines(fitted(status))).startswith(status)


def printed(status: Status, contacts: int = 3, color: bool = False, width: int = 80, **options: Any) -> str:
    file = io.StringIO()
    console = Console(file=file, width=width, force_terminal=color, color_system="standard" if color else None)
    console.print(summary(answer(status, contacts), **options))
    return file.getvalue()


@pytest.mark.parametrize("status", STATUSES)
def test_the_summary_fits_a_terminal_and_needs_no_color(status: Status) -> None:
    text = printed(status)
    assert max(map(len, text.splitlines())) <= 80
    assert "\x1b" not in text
    assert "\x1b" in printed(status, color=True)
    assert status in text
    assert "cell" in text


@pytest.mark.parametrize("status", STATUSES)
@pytest.mark.parametrize("width", [40, 60])
def test_a_narrow_terminal_cuts_no_number_off(status: Status, width: int) -> None:
    text = printed(status, width=width)
    assert max(map(len, text.splitlines())) <= width
    assert "…" not in text


def test_the_summary_shows_the_pose_to_the_digits_that_are_known() -> None:
    text = printed("located")
    assert "0.33333" in text  # sigma 4e-4: the first digit of sigma, and one more
    assert "12345.67890" in text
    assert "4e-04" in text or "0.0004" in text
    assert "53.1301" in text  # atan2(0.8, 0.6) about z


def test_the_summary_contains_a_requested_point() -> None:
    assert "(100, 0, 0) mm" in printed("located", at=np.array([100.0, 0.0, 0.0]))


def test_bars_grow_with_the_residual_and_point_its_way() -> None:
    lines = [line for line in printed("located", ascii_only=True).splitlines() if "|" in line and "bar " in line]
    assert [line.split()[2] for line in lines] == ["+0.0000333", "-0.0000667", "+0.0001000"]
    bars = [line.split(maxsplit=3)[3] for line in lines]
    left_and_right = [tuple(side.count("#") for side in bar.partition("|")[::2]) for bar in bars]
    assert left_and_right == [(0, 3), (7, 0), (0, 10)]


def test_of_many_contacts_the_worst_are_shown() -> None:
    text = printed("located", contacts=500)
    assert "the largest 20 of 500" in text
    assert "500  bar" in text
    assert len(text.splitlines()) < 60


def test_a_name_with_brackets_is_no_markup() -> None:
    assert "[0.2, 6.0]" in printed("inconsistent")


@pytest.mark.parametrize(
    ("value", "sigma", "sign", "text"),
    [
        (1234567.4321, 0.02, "", "1234567.432"),
        (1234567.4321, None, "", "1234567.4321"),
        (0.1, 0.11, "+", "+0.10"),
        (-0.1, 0.11, "+", "-0.10"),
        (-1e-9, 0.11, "+", "+0.00"),
        (1300.0, None, "+", "+1300"),
        (4e-7, None, "", "0.0000004"),
        (1.23456789e-5, None, "", "0.0000123457"),
        (0.0, 0.0, "", "0"),
        (20.0, 300.0, "", "20"),
    ],
)
def test_a_number_has_the_digits_that_its_sigma_bears(value: float, sigma: float | None, sign: str, text: str) -> None:
    assert borne(value, sigma, sign) == text
