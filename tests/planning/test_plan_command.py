"""The command plan."""

import json
import os
import pty
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from tactfix.cli import main
from tactfix.files.contact_source import load_contacts
from tactfix.files.fixture_file import load_fixture
from tests.support.project import FIXTURES

CELL = str(FIXTURES / "robot-cell-plate.yaml")
RUN = [sys.executable, "-c", "import sys; from tactfix.cli import main; sys.exit(main())"]


def test_a_plan_is_a_contact_file_in_the_fixture_frame(tmp_path, capsys):
    path = tmp_path / "plan.csv"
    assert main(["plan", CELL, "--contacts", "8", "--output", str(path)]) == 0
    assert not capsys.readouterr().out
    contacts = load_contacts(path, load_fixture(CELL))
    assert len(contacts) == 8
    assert contacts.tip_radius == 3.0
    assert main(["locate", CELL, str(path)]) == 0
    assert np.allclose(np.loadtxt(capsys.readouterr().out.splitlines()), np.eye(4), atol=1e-3)


def test_plan_simulate_locate(tmp_path, capsys):
    plan, contacts = tmp_path / "plan.csv", tmp_path / "contacts.csv"
    assert main(["plan", CELL, "--contacts", "9", "-o", str(plan)]) == 0
    assert main(["simulate", CELL, str(plan), "--seed", "3", "-o", str(contacts)]) == 0
    assert main(["locate", CELL, str(contacts)]) == 0
    pose = np.loadtxt(capsys.readouterr().out.splitlines())
    assert np.linalg.norm(pose[:3, 3]) > 900


def test_json_states_the_quality_of_the_plan(capsys):
    assert main(["plan", CELL, "--contacts", "8", "--json", "--criterion", "d"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["schema"] == "tactfix/plan/1"
    assert report["criterion"] == "d"
    assert report["unique"] is True
    assert len(report["contacts"]) == 8
    assert np.array(report["covariance"]).shape == (6, 6)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--contacts", "5"], "6 or more"),
        (["--contacts", "201"], "200 or fewer"),
        (["--add", "2"], "nothing to add to"),
        (["--contacts", "8", "--tip-radius", "-1"], "tip radius"),
    ],
)
def test_refusals(arguments, message, capsys):
    assert main(["plan", CELL, *arguments]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert message in err


def test_a_symmetric_fixture_has_no_unique_plan(tmp_path, capsys):
    path = tmp_path / "plan.csv"
    fixture = tmp_path / "symmetric.yaml"
    text = (FIXTURES / "cylinder-sphere.yaml").read_text()
    fixture.write_text(text[: text.index("touch:")])
    assert main(["plan", str(fixture), "--contacts", "8", "-o", str(path)]) == 1
    assert "more than one pose" in capsys.readouterr().err
    assert "not unique" in path.read_text()


def test_features_that_leave_a_motion_free_are_refused(tmp_path, capsys):
    fixture = tmp_path / "ball.yaml"
    text = "tactfix: 1\nname: one-ball\nunits: mm\nprobe: {tip_radius: 1.0, sigma: 0.01}\n"
    fixture.write_text(text + "features:\n  ball: {type: sphere, radius: 5.0, center: [0.0, 0.0, 0.0]}\n")
    assert main(["plan", str(fixture), "--contacts", "8"]) == 2
    assert "motion stays free" in capsys.readouterr().err


@pytest.mark.slow
def test_an_interrupt_keeps_the_old_file_and_a_terminal_shows_progress(tmp_path):
    path = tmp_path / "plan.csv"
    path.write_text("old")
    master, terminal = pty.openpty()
    with subprocess.Popen([*RUN, "plan", CELL, "-o", str(path)], stderr=terminal, stdout=subprocess.PIPE) as process:
        os.close(terminal)
        shown = b""
        while b"planning" not in shown:
            shown += os.read(master, 4096)
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == 130
        assert not process.stdout.read()
    os.close(master)
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["plan.csv"]
