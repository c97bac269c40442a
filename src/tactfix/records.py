"""Whole files in, rows and records out: batch, report and calibrate as calls from Python."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

from tactfix.batching.processes import LocalProcesses
from tactfix.batching.row import BatchRow
from tactfix.batching.task import BatchTask
from tactfix.batching.workers import here, spread_over
from tactfix.calibration.calibrate import calibrate as calibrated
from tactfix.calibration.cell import Touches
from tactfix.calibration.result import Calibration
from tactfix.contacts import Contacts
from tactfix.files.cell_file import CellFile
from tactfix.files.contact_options import ContactOptions
from tactfix.files.contact_sets import SetReader, find_sets
from tactfix.files.log_options import log_options
from tactfix.files.reading import Source, read_bytes
from tactfix.files.touch_file import load_touches as read_touches
from tactfix.fixture import Fixture
from tactfix.report.html_page import InputFile, Judgement, Record, locate_page
from tactfix.report.text_report import sentence
from tactfix.results import LocateResult


def batch(
    fixture: Fixture,
    sources: Sequence[str | Path],
    options: ContactOptions | None = None,
    *,
    format: str = "csv",  # noqa: A002 - as the command line calls it
    features: str | None = None,
    approach: str | None = None,
    scale_sigma: bool = False,
    max_sigma: float | None = None,
    max_rms: float | None = None,
    at: tuple[float, float, float] | None = None,
    jobs: int = 1,
) -> tuple[BatchRow, ...]:
    """Locate every contact set in files, directories and tables: a row for each, in order, whatever becomes of it.

    options, format, features and approach as of load_contacts. A located set is acceptable unless the worst sigma of
    the origin, or of the point at (3,), is above max_sigma, or the rms above max_rms (fixture's units).
    jobs: processes. Rows become a table with pandas.DataFrame(rows). Raises FileError where a source cannot be found.
    """
    said = options or ContactOptions()
    task = BatchTask(
        fixture=fixture,
        read=SetReader(format, said, log_options(features, said.tip_offset, approach)),
        describe=sentence,
        scale_sigma=scale_sigma,
        max_sigma=max_sigma,
        max_rms=max_rms,
        point_fixture=at,
    )
    sets = find_sets([str(source) for source in sources], format)
    spread = here if jobs == 1 else partial(spread_over, LocalProcesses(jobs))
    rows = dict(spread(task, iter(enumerate(sets))))
    return tuple(rows[number] for number in range(len(rows)))


def calibrate(
    cell: CellFile, touches: Touches, *, hold_out: Sequence[str] = (), unchecked: bool = False
) -> Calibration:
    """Calibrate the robot of a cell from touches on fixtures that stand at unknown places.

    Parameters
    ----------
    cell : CellFile
        What `load_cell` read: robot, probe, prior, fixtures and places.
    touches : Touches
        What `load_touches` read: joints in rad and the cell's units.
    hold_out : sequence of str
        Places kept out of all of it; `left_out` tells their residuals with the nominal and the calibrated robot.
    unchecked : bool
        Let touches at one place do, which nothing can check.

    Returns
    -------
    Calibration
        status is "calibrated" only where places left out speak for the robot; `write_robot` writes it.

    Raises UsageError for places that are not there or not touched.
    """
    return calibrated(cell.cell, touches, hold_out, unchecked)


def load_touches(source: Source, cell: CellFile) -> Touches:
    """The touches of a CSV file (or "-", standard input) on the fixtures of a cell: place, feature, q1 to qn.

    In rad and the cell's units. Raises FileError with all that is wrong, by row and line.
    """
    return read_touches(source, cell.cell, cell.sigma)


def html_report(
    fixture: Fixture,
    contacts: Contacts,
    result: LocateResult,
    *,
    inputs: Mapping[str, str | Path] | None = None,
    notes: Mapping[str, str] | None = None,
) -> str:
    """The record of a locate as one HTML page that works offline, as `tactfix report` writes it.

    result: what locate found of contacts. inputs: files that the page names with their checksums, by what they are,
    such as {"fixture": "plate.yaml"}. notes: what stands on the record besides, such as {"operator": "Ada"}.
    Raises MissingExtraError without the extra report; FileError for an input that cannot be read.
    """
    files = [InputFile(role, str(path), read_bytes(str(path))) for role, path in (inputs or {}).items()]
    record = Record(fixture, files, {}, datetime.now(UTC), dict(notes or {}))
    return locate_page(record, contacts, result, Judgement())
