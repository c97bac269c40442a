"""The command guide on a file, a growing file, a pipe and a machine log; and the command check."""

import json
import subprocess
import sys
import time
from functools import cache
from pathlib import Path

import pytest

from tactfix import guide, load_contacts, load_fixture
from tests.support.command_line import tactfix
from tests.support.project import ROOT

FIXTURE_PATH = ROOT / "fixtures" / "robot-cell-plate.yaml"
CONTACTS_PATH = ROOT / "samples" / "robot-cell-plate" / "contacts.csv"
FIXTURE = load_fixture(FIXTURE_PATH)
CONTACTS = load_contacts(CONTACTS_PATH, FIXTURE)
LINES = CONTACTS_PATH.read_text().splitlines(keepends=True)
HEADER = next(k for k, line in enumerate(LINES) if line.startswith("feature")) + 1


def statuses(*words: object, stdin: str = "") -> tuple[int, list[dict]]:
    done = tactfix("guide", FIXTURE_PATH, *words, "--json", stdin=stdin)
    return done.returncode, [json.loads(line) for line in done.stdout.splitlines()]


@cache
def of_the_sample() -> tuple[int, list[dict]]:
    """Exit status and steps of guide for the sample's contacts, shared by the tests that compare with them."""
    return statuses(CONTACTS_PATH)


def test_each_step_equals_locate_of_the_touches_so_far() -> None:
    status, steps = of_the_sample()
    assert status == 0
    assert [step["touches"] for step in steps] == list(range(1, len(steps) + 1))
    assert [step["done"] for step in steps] == [False] * (len(steps) - 1) + [True]
    assert steps[-1]["status"] == "located"
    for step in steps:
        alone = guide(FIXTURE, CONTACTS.subset(range(step["touches"])))
        assert (step["status"], step["state"], step["advice"]) == (alone.result.status, alone.state, alone.advice)
    assert all(step["transform"] is None for step in steps[:-1])


def test_guide_reads_standard_input_like_a_file() -> None:
    assert statuses(stdin=CONTACTS_PATH.read_text()) == of_the_sample()
    # The last line counts although it has no line end.
    _, steps = statuses("-", stdin="".join(LINES[: HEADER + 4]).rstrip("\n"))
    assert steps == of_the_sample()[1][:4]


@pytest.mark.parametrize(("touches", "status"), [(0, 4), (3, 4), (8, 4)])
def test_too_few_touches_exit_with_the_status_of_the_last_step(touches: int, status: int) -> None:
    done = tactfix("guide", FIXTURE_PATH, stdin="".join(LINES[: HEADER + touches]))
    assert done.returncode == status
    assert len(done.stdout.splitlines()) == touches
    assert "ended before" in done.stderr


def test_a_step_is_one_touch_to_make() -> None:
    """The text names only the next touch, because the others may change after it; the JSON has all of them."""
    first = of_the_sample()[1][0]
    assert len(first["next_contact"]["further"]) == 4
    assert first["advice"].count("moving along") == 1
    assert first["advice"].endswith("at least 5 contacts are missing")


def test_guide_continues_until_gates_are_met() -> None:
    _, steps = of_the_sample()
    status, gated = statuses(CONTACTS_PATH, "--max-sigma", "1e-6")
    assert status == 1
    assert len(gated) == len(CONTACTS) >= len(steps)
    assert gated[-1]["exceeded"]


def test_a_wrong_touch_is_reported_and_guidance_continues() -> None:
    lines = LINES[:HEADER] + LINES[HEADER:]
    cells = lines[HEADER + 1].split(",")
    cells[3] = str(float(cells[3]) + 25.0)
    lines[HEADER + 1] = ",".join(cells)
    status, steps = statuses(stdin="".join(lines))
    assert status == 6
    assert len(steps) == len(CONTACTS)
    assert steps[-1]["status"] == "inconsistent"


def test_an_invalid_row_ends_guide_with_its_position() -> None:
    done = tactfix("guide", FIXTURE_PATH, stdin="".join([*LINES[: HEADER + 2], "plate,1,2\n"]))
    assert done.returncode == 3
    assert "standard input" in done.stderr
    assert "row 3" in done.stderr
    assert len(done.stdout.splitlines()) == 2


def test_a_growing_file_is_followed_until_the_fixture_is_located(tmp_path: Path) -> None:
    path = tmp_path / "contacts.csv"
    path.write_text("".join(LINES[:HEADER]))
    script = "import sys; from tactfix.cli import main; sys.exit(main())"
    words = ["guide", str(FIXTURE_PATH), str(path), "--follow", "--json"]
    with subprocess.Popen([sys.executable, "-c", script, *words], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for number, line in enumerate(LINES[HEADER:], 1):
            with path.open("a") as file:
                # An incomplete line is read after it is completed.
                file.write(line[:7])
                file.flush()
                if number == 3:
                    time.sleep(0.5)
                file.write(line[7:])
            step = json.loads(process.stdout.readline())
            assert step["touches"] == number
            if step["done"]:
                break
        assert process.wait(10) == 0


def test_a_machine_log_with_features_given_beforehand(tmp_path: Path) -> None:
    log = tmp_path / "probe.txt"
    rows = [f"[PRB:{x:.4f},{y:.4f},{z:.4f}:1]\n" for x, y, z in CONTACTS.points]
    runs: list[tuple[str, int]] = []
    for name in CONTACTS.features:
        runs = [*runs[:-1], (name, runs[-1][1] + 1)] if runs and runs[-1][0] == name else [*runs, (name, 1)]
    features = ",".join(f"{name}:{count}" for name, count in runs)
    tip = ["--tip-radius", CONTACTS.tip_radius, "--sigma", CONTACTS.sigmas[0], "--units", FIXTURE.units]
    log.write_text("".join(rows[:4]))
    status, steps = statuses(log, "--contacts-format", "grbl", "--features", features, *tip)
    assert status == 4
    assert [step["touches"] for step in steps] == [1, 2, 3, 4]


def test_a_repeated_touch_replaces_the_first(tmp_path: Path) -> None:
    """A fast touch, then a slow one: with --repeats last each is a step, but each place is one contact."""
    log = tmp_path / "probe.txt"
    points = CONTACTS.points[:3]
    rows = [f"[PRB:{x + off:.4f},{y:.4f},{z:.4f}:1]\n" for x, y, z in points for off in (0.05, 0.0)]
    log.write_text("".join(rows))
    tip = ["--tip-radius", CONTACTS.tip_radius, "--sigma", CONTACTS.sigmas[0], "--units", FIXTURE.units]
    words = (log, "--contacts-format", "grbl", "--features", "plate:3", *tip)
    assert [step["touches"] for step in statuses(*words, "--repeats", "last")[1]] == [1, 1, 2, 2, 3, 3]
    # Three places fit three features; counted as six touches they would be too many.
    done = tactfix("guide", FIXTURE_PATH, *words)
    assert done.returncode == 3
    assert "touches" in done.stderr or "contacts" in done.stderr


@pytest.fixture
def reference(tmp_path: Path) -> Path:
    path = tmp_path / "reference.json"
    assert tactfix("locate", FIXTURE_PATH, CONTACTS_PATH, "--output", path).returncode == 0
    return path


def test_check_has_a_verdict_in_words_and_an_exit_status(reference: Path, tmp_path: Path) -> None:
    words = ("check", FIXTURE_PATH, CONTACTS_PATH, "--reference", reference)
    still = tactfix(*words, "--history", tmp_path / "history.jsonl")
    assert still.returncode == 0
    assert still.stdout.startswith("has not moved: less than 0.")
    pose_json = json.loads(reference.read_text())
    pose_json["transform"][0][3] += 3.0
    reference.write_text(json.dumps(pose_json))
    moved = tactfix(*words)
    assert moved.returncode == 1
    assert moved.stdout.startswith("HAS MOVED: 3 mm at its origin")
    limited = tactfix(*words, "--limit-translation", "5", "--json")
    assert limited.returncode == 0
    answer = json.loads(limited.stdout)
    assert answer["status"] == "not_moved"
    assert answer["verdict"].startswith("has moved within the limits")
    assert answer["distance"] == pytest.approx(3.0)
    assert answer["worst_point"]["displacement"] == pytest.approx(3.0)
    assert answer["locate"]["status"] == "located"
    assert answer["drift"] is None


def test_a_history_of_three_checks_reports_a_drift(reference: Path, tmp_path: Path) -> None:
    history = tmp_path / "history.jsonl"
    words = ("check", FIXTURE_PATH, CONTACTS_PATH, "--reference", reference, "--history", history)
    outputs = [tactfix(*words).stdout for _ in range(3)]
    assert ["drift:" in output for output in outputs] == [False, False, True]
    assert len(history.read_text().splitlines()) == 3


def test_the_commands_check_and_compare_reject_another_fixture(reference: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.json"
    other.write_text(reference.read_text().replace(FIXTURE.name, "another"))
    refused = tactfix("check", FIXTURE_PATH, CONTACTS_PATH, "--reference", other)
    assert (refused.returncode, refused.stdout) == (3, "")
    assert "'another'" in refused.stderr
    assert tactfix("compare", reference, other).returncode == 3


def test_check_of_contacts_that_do_not_locate(reference: Path, tmp_path: Path) -> None:
    few = tmp_path / "few.csv"
    few.write_text("".join(LINES[: HEADER + 3]))
    history = tmp_path / "history.jsonl"
    done = tactfix("check", FIXTURE_PATH, few, "--reference", reference, "--history", history, "--json")
    assert done.returncode == 4
    assert json.loads(done.stdout)["status"] == "underdetermined"
    assert not history.exists()
    assert tactfix("check", FIXTURE_PATH, few).returncode == 2
