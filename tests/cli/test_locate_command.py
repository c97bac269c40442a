"""The command locate: options are applied, results are written to the right output, and the exit status is correct."""

import io
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tactfix.acceptance import point_covariance
from tactfix.cli import main
from tactfix.contacts import Contacts
from tactfix.fixture import Fixture
from tactfix.locate_result import LocateResult
from tactfix.results import Status
from tests.support.answers import BASE_FROM_FIXTURE, COVARIANCE, LOCATING, answer
from tests.support.project import ROOT

Answers = Callable[[Status], None]
RUN = ("locate", "fixture.yaml", "contacts.csv")
pytestmark = pytest.mark.usefixtures("folder")


@pytest.mark.parametrize(
    ("status", "code"), [("located", 0), ("underdetermined", 4), ("ambiguous", 5), ("inconsistent", 6)]
)
def test_the_exit_status_and_what_is_printed(
    answers: Answers, capsys: pytest.CaptureFixture[str], status: Status, code: int
) -> None:
    answers(status)
    assert main(RUN) == code
    out, err = capsys.readouterr()
    if status == "located":
        np.testing.assert_array_equal(np.loadtxt(io.StringIO(out)), BASE_FROM_FIXTURE)
    else:
        assert out == ""
        assert f"tactfix: {status}: " in err
    assert "row 3 is within two sigma" in err


@pytest.mark.parametrize("status", ["located", "underdetermined", "ambiguous", "inconsistent"])
def test_json_in_any_case(answers: Answers, capsys: pytest.CaptureFixture[str], status: Status) -> None:
    answers(status)
    for options in (["--json"], ["--format", "json"], ["--json", "-f", "json"]):
        main([*RUN, *options])
        report = json.loads(capsys.readouterr().out)
        assert report["status"] == status
        assert (report["transform"] is None) == (status != "located")


def test_quiet_is_quiet_but_not_about_failure(answers: Answers, capsys: pytest.CaptureFixture[str]) -> None:
    answers("located")
    assert main([*RUN, "--quiet"]) == 0
    assert capsys.readouterr().err == ""
    answers("ambiguous")
    assert main([*RUN, "--quiet"]) == 5
    err = capsys.readouterr().err
    assert "ambiguous" in err
    assert "two sigma" not in err


def test_a_summary_for_people_and_not_for_pipes(
    answers: Answers, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    answers("located")
    main(RUN)
    assert "in base" not in capsys.readouterr().err
    main([*RUN, "--verbose"])
    out, err = capsys.readouterr()
    assert "in base" in err
    assert len(out.splitlines()) == 4
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    main(RUN)
    assert "in base" in capsys.readouterr().err
    main([*RUN, "--quiet"])
    assert capsys.readouterr().err == ""


def test_candidates_that_differ_in_rotation_are_distinguished(capsys: pytest.CaptureFixture[str]) -> None:
    # An axis has no sign: the four poses have two different origins, two poses each.
    words = [str(ROOT / "fixtures/cylinder-sphere.yaml"), str(ROOT / "samples/cylinder-sphere/contacts.csv")]
    assert main(["locate", *words, "--verbose"]) == 0
    rows = [
        line.split()
        for line in capsys.readouterr().err.splitlines()
        if line.startswith((" 1  ", " 2  ", " 3  ", " 4  "))
    ]
    poses = [tuple(row[1:7]) for row in rows if "accepted" in row or "rejected:" in row]
    assert len({pose[:3] for pose in poses}) == 2
    assert len({tuple(map(float, pose)) for pose in poses}) == 4


def test_the_suffix_of_the_output_chooses_the_format(
    answers: Answers, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    answers("located")
    for name in ("pose.json", "pose.txt", "pose", "POSE.JSON", "frame.src"):
        assert main([*RUN, "--output", name]) == 0
        assert capsys.readouterr().out == ""
    assert json.loads((folder / "pose.json").read_text())["transform"] == BASE_FROM_FIXTURE.tolist()
    assert (folder / "POSE.JSON").read_text() == (folder / "pose.json").read_text()
    np.testing.assert_array_equal(np.loadtxt(folder / "pose.txt"), BASE_FROM_FIXTURE)
    np.testing.assert_array_equal(np.loadtxt(folder / "pose"), BASE_FROM_FIXTURE)
    assert "{X 0.333333,Y " in (folder / "frame.src").read_text()
    assert main([*RUN, "--output", "pose.txt", "--format", "json"]) == 0
    assert json.loads((folder / "pose.txt").read_text())["status"] == "located"


def test_without_a_pose_no_file_is_touched(answers: Answers, folder: Path) -> None:
    answers("ambiguous")
    (folder / "pose.txt").write_text("the old pose")
    assert main([*RUN, "--output", "pose.txt"]) == 5
    assert (folder / "pose.txt").read_text() == "the old pose"
    assert main([*RUN, "--output", "pose.json"]) == 5
    assert json.loads((folder / "pose.json").read_text())["transform"] is None


def test_a_dialect(answers: Answers, capsys: pytest.CaptureFixture[str]) -> None:
    answers("located")
    assert main([*RUN, "--format", "kuka"]) == 0
    out, err = capsys.readouterr()
    assert "A 53.130102" in out
    assert "rounds" not in err  # six decimals are far finer than the sigma of this pose


@pytest.mark.parametrize(
    ("options", "code"),
    [
        (["--max-sigma", "7e-4"], 0),
        (["--max-sigma", "5e-4"], 1),  # the largest sigma is along z: 6e-4
        (["--max-rms", "2e-4"], 0),
        (["--max-rms", "0.5e-4"], 1),
        (["--max-sigma", "1", "--max-rms", "0"], 1),
        (["--max-sigma", "7e-4", "--at", "1000,0,0"], 1),
        (["--max-sigma", "4e-3", "--at", "1000,0,0"], 0),
    ],
)
def test_gates(answers: Answers, capsys: pytest.CaptureFixture[str], options: list[str], code: int) -> None:
    answers("located")
    assert main([*RUN, *options]) == code
    out, err = capsys.readouterr()
    assert len(out.splitlines()) == 4
    assert ("not acceptable" in err) == (code == 1)


def test_a_gate_does_not_hide_a_status_other_than_located(answers: Answers) -> None:
    answers("ambiguous")
    assert main([*RUN, "--max-rms", "0"]) == 5


def test_sigma_at_a_point_by_noise_made_here() -> None:
    """Against the scatter of the point under small motions drawn from the covariance."""
    rng = np.random.default_rng(3)
    point = np.array([300.0, -200.0, 50.0])
    mixed = rng.normal(size=(6, 6)) * 1e-5
    covariance = mixed @ mixed.T
    motions = rng.multivariate_normal(np.zeros(6), covariance, size=200_000)
    arm = BASE_FROM_FIXTURE[:3, :3] @ point
    moved = np.cross(motions[:, :3], arm) + motions[:, 3:]
    np.testing.assert_allclose(
        point_covariance(BASE_FROM_FIXTURE, covariance, point), np.cov(moved.T), rtol=0.02, atol=0.01 * moved.var()
    )
    at_origin = point_covariance(BASE_FROM_FIXTURE, COVARIANCE, np.zeros(3))
    np.testing.assert_array_equal(at_origin, COVARIANCE[3:, 3:])


def test_a_requested_point_is_reported(answers: Answers, capsys: pytest.CaptureFixture[str]) -> None:
    answers("located")
    assert main([*RUN, "--at", "1000,0,0"]) == 0
    assert "worst sigma at 1000,0,0: 0.00" in capsys.readouterr().err
    assert main([*RUN, "--at", "1000,0,0", "--json"]) == 0
    at = json.loads(capsys.readouterr().out)["at"]
    np.testing.assert_allclose(at["point"], BASE_FROM_FIXTURE[:3] @ [1000, 0, 0, 1])
    assert at["worst_sigma"] == pytest.approx(np.sqrt(np.linalg.eigvalsh(at["covariance"])[-1]))
    answers("ambiguous")
    assert main([*RUN, "--at", "1000,0,0", "--json"]) == 5
    at = json.loads(capsys.readouterr().out)["at"]
    assert at == {"point_fixture": [1000.0, 0.0, 0.0], "point": None, "covariance": None, "worst_sigma": None}


def test_options_reach_the_contacts(monkeypatch: pytest.MonkeyPatch) -> None:
    received: list[Contacts] = []

    def locate(_: Fixture, contacts: Contacts, *, scale_sigma: bool, **more: object) -> LocateResult:
        assert scale_sigma
        received.append(contacts)
        return answer()

    monkeypatch.setattr(LOCATING, "locate", locate)
    assert main([*RUN, "--units", "m", "--tip-radius", "0.003", "--sigma", "1e-5", "--scale-sigma"]) == 0
    assert received[0].tip_radius == 3.0
    assert received[0].sigmas[0] == pytest.approx(0.01)
    assert received[0].points[0, 1] == 2000.0


def test_contacts_from_standard_input(answers: Answers, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    answers("located")
    text = io.TextIOWrapper(io.BytesIO((folder / "contacts.csv").read_bytes()))
    monkeypatch.setattr("sys.stdin", text)
    assert main(["locate", "fixture.yaml", "-"]) == 0


def test_a_machine_log(monkeypatch: pytest.MonkeyPatch, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    received: list[Contacts] = []
    monkeypatch.setattr(LOCATING, "locate", lambda _, contacts, **__: received.append(contacts) or answer())
    (folder / "grbl.txt").write_text("[PRB:1.0,2.0,3.0:1]\nok\n[PRB:0,0,0:0]\n[PRB:4.0,5.0,6.0:1]\n")
    options = [
        "--contacts-format",
        "grbl",
        "--features",
        "bar:1,ball:1",
        "--units",
        "mm",
        "--tip-radius",
        "3",
        "--sigma",
        "1",
    ]
    assert main(["locate", "fixture.yaml", "grbl.txt", *options]) == 0
    assert received[0].features == ("bar", "ball")
    assert "dropped" in capsys.readouterr().err


@pytest.mark.parametrize(
    "options",
    [
        ["--json", "--format", "kuka"],
        ["--format", "klingon"],
        ["--output", "pose.xyz"],
        ["--at", "1,2"],
        ["--at", "1,2,nan"],
        ["--max-sigma", "-1"],
        ["--max-rms", "lots"],
        ["--sigma", "0"],
        ["--tip-radius", "-1"],
        ["--units", "ft"],
        ["--features", "bar:3"],
        ["--contacts-format", "morse"],
        ["--nonsense"],
        ["one argument too many"],
    ],
)
def test_usage(answers: Answers, capsys: pytest.CaptureFixture[str], options: list[str]) -> None:
    answers("located")
    assert main([*RUN, *options]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err
    assert "Traceback" not in err
