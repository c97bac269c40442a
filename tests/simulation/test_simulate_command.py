"""The command simulate: pipes, files, the true pose in comments, rejected input."""

import json
import re

import numpy as np
import pytest

from tactfix.cli import main
from tactfix.report.plan_report import simulation_csv
from tactfix.simulation.simulate import simulate
from tests.support.command_line import tactfix
from tests.support.placed_cells import ball_and_bar
from tests.support.project import FIXTURES

SHIPPED = sorted(FIXTURES.glob("*.yaml"))
CELL = str(FIXTURES / "robot-cell-plate.yaml")


def true_pose(text):
    """The true pose stated in the comments of a simulated file."""
    rows = [line.removeprefix("# truth: ").split() for line in text.splitlines() if line.startswith("# truth: ")]
    return np.array([[float(cell) for cell in row] for row in rows if len(row) == 4 and row[0][0] in "-0123456789"])


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_simulate_pipes_into_locate_and_gives_the_pose_back(path):
    simulated = tactfix("simulate", path, "--seed", "7")
    found = tactfix("locate", path, "-", "--json", stdin=simulated.stdout)
    assert found.returncode == 0, found.stderr
    result = json.loads(found.stdout)
    off = np.array(result["transform"]) - true_pose(simulated.stdout)
    sigmas = np.sqrt(np.diag(result["covariance"]))
    assert (np.abs(off[:3, 3]) < 6 * sigmas[3:]).all()
    assert np.abs(off[:3, :3]).max() < 6 * np.linalg.norm(sigmas[:3])


def test_one_seed_gives_one_file_to_the_byte(capsys):
    texts = []
    for seed in ("4", "4", "5"):
        assert main(["simulate", CELL, "--seed", seed]) == 0
        texts.append(capsys.readouterr().out)
    assert texts[0] == texts[1] != texts[2]


# Recorded output: if it changes, every simulated file changes.
ONE_FILE = """\
# simulated contacts on ball-and-bar
# truth: base_from_fixture, x_base = R x_fixture + t, row by row:
# truth: -0.413083865733 0.570177894244 0.710111884696 -2470.647347383696
# truth: -0.891407065892 -0.412773503933 -0.187113541276 -1023.514611773963
# truth: 0.186427365881 -0.710292336553 0.678770678422 -278.377584584741
# truth: 0.0 0.0 0.0 1.0
# truth: seed 1
# truth: no fault
# truth: random touches, approached from within 20 degrees of the normal
# units: mm
# tip_radius: 1.0
# sigma: 0.005
feature,x,y,z,ax,ay,az
bar,-2452.716813,-1030.368573,-286.410444,-0.831140846,-0.098994366,-0.547179138
ball,-2477.345032,-1040.98167,-271.221907,-0.525841129,-0.850582739,-0.000332778
"""


def test_a_seed_reproduces_the_recorded_file():
    assert simulation_csv(simulate(ball_and_bar(), count=2, seed=1)) == ONE_FILE


def test_numbers_have_no_more_digits_than_they_mean(capsys):
    main(["simulate", CELL])
    rows = [
        line.split(",") for line in capsys.readouterr().out.splitlines() if line.startswith(("plate", "pin", "ball"))
    ]
    assert max(len(cell.partition(".")[2]) for row in rows for cell in row[1:4]) <= 5


def test_a_given_pose_is_the_truth(tmp_path, capsys):
    pose = tmp_path / "pose.txt"
    matrix = np.array([[0, -1, 0, 10], [1, 0, 0, 20], [0, 0, 1, 30], [0, 0, 0, 1.0]])
    np.savetxt(pose, matrix)
    assert main(["simulate", CELL, "--pose", str(pose)]) == 0
    assert np.allclose(true_pose(capsys.readouterr().out), matrix)


def test_the_pose_of_another_fixture_is_noted(capsys):
    own, other = "samples/robot-cell-plate/expected.json", "samples/three-planes/expected.json"
    assert main(["simulate", CELL, "--pose", own]) == 0
    assert capsys.readouterr().err == ""
    assert main(["simulate", CELL, "--pose", other]) == 0
    assert "is it the right pose?" in capsys.readouterr().err


def test_output_is_a_file_and_json_has_the_truth_too(tmp_path, capsys):
    main(["simulate", CELL, "--fault", "outlier:2", "--json", "--output", str(tmp_path / "contacts.json")])
    assert not capsys.readouterr().out
    report = json.loads((tmp_path / "contacts.json").read_text())
    assert report["fault"] == "outlier"
    assert "off by 2" in report["mistake"]
    assert np.array(report["transform"]).shape == (4, 4)


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["--fault", "outlyer"], 2, "outlier"),
        (["--contacts", "0"], 2, "one or more"),
        (["--contacts", "1" * 25], 2, "100000 at most"),
        (["--sigma", "-1"], 2, "sigma"),
        (["--pose", "nowhere.json"], 3, "nowhere.json"),
        (["nowhere.csv"], 3, "nowhere.csv"),
    ],
)
def test_refusals(arguments, status, message, capsys):
    assert main(["simulate", CELL, *arguments]) == status
    out, err = capsys.readouterr()
    assert not out
    assert message in err


def test_contacts_that_were_made_are_no_plan(tmp_path):
    contacts_file = tmp_path / "made.csv"
    assert tactfix("simulate", CELL, "--seed", 7, "--output", contacts_file).returncode == 0
    done = tactfix("simulate", CELL, contacts_file)
    assert (done.returncode, done.stdout) == (3, "")
    assert re.match(
        rf"tactfix: {re.escape(str(contacts_file))}: row \d+: this touch is \d+ mm off \w+ in the fixture", done.stderr
    )
    assert "tactfix plan makes one" in done.stderr
