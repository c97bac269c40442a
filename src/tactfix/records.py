"""Python functions for whole files: batch, calibrate and the HTML report."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

from tactfix.batching.batch import here, spread_over
from tactfix.batching.processes import LocalProcesses
from tactfix.batching.row import BatchRow
from tactfix.batching.task import BatchTask
from tactfix.calibration.calibrate import calibrate as calibrated
from tactfix.calibration.cell import Touches
from tactfix.calibration.result import Calibration
from tactfix.contacts import Contacts
from tactfix.files.cell_file import CellFile
from tactfix.files.contact_options import ContactOptions, log_options
from tactfix.files.contact_sets import SetReader, find_sets
from tactfix.files.reading import Source, read_bytes
from tactfix.files.touch_file import load_touches as read_touches
from tactfix.fixture import Fixture
from tactfix.locate_result import LocateResult
from tactfix.report.html_page import InputFile, Judgement, Record, locate_page
from tactfix.report.text_report import sentence


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
    """Locate every contact set in files, directories and tables: one row for each, in order, whether located or not.

    Parameters
    ----------
    fixture : Fixture
        The fixture touched in all sets.
    sources : sequence of str or Path
        Files, directories, and tables with a column set.
    options : ContactOptions, optional
        As format, features and approach: see `load_contacts`.
    format : str
        "csv", or the name of a machine's format.
    features : str, optional
        Names of the touched features, in order.
    approach : str, optional
        The direction in which the probe travelled.
    scale_sigma : bool
        As of `locate`.
    max_sigma : float, optional
        A located set is acceptable unless the worst sigma of the origin, or of the point at, is above it (units).
    max_rms : float, optional
        The same for the rms of its residuals (units).
    at : tuple of three floats, optional
        The point (3,) of the fixture frame at which max_sigma applies.
    jobs : int
        Number of processes.

    Returns
    -------
    tuple of BatchRow
        `pandas.DataFrame(rows)` makes a table of them.

    Raises
    ------
    FileError
        A source that cannot be found.

    Notes
    -----
    A set that cannot be read or located is a row with its message; the batch goes on.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> [row.status for row in tactfix.batch(fixture, ["samples/robot-cell-plate/contacts.csv"])]
    ['located']
    """
    given = options or ContactOptions()
    task = BatchTask(
        fixture=fixture,
        read=SetReader(format, given, log_options(features, given.tip_offset, approach)),
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
    """Calibrate the robot of a cell from touches on fixtures at unknown places.

    Parameters
    ----------
    cell : CellFile
        What `load_cell` read: robot, probe, prior, fixtures and places.
    touches : Touches
        What `load_touches` read: joints in rad and the cell's units.
    hold_out : sequence of str
        Places excluded from the fit; `left_out` has their residuals with the nominal and the calibrated robot.
    unchecked : bool
        Accept touches at a single place, without validation.

    Returns
    -------
    Calibration
        status is "calibrated" only if places left out confirm the robot; `write_robot` writes it.

    Raises
    ------
    UsageError
        Places that do not exist or are not touched.

    Notes
    -----
    Minimises the sum of (f_i(place_i^-1 tip(q_i, p)) - r)^2 / sigma_i^2 + p^T P^-1 p / factor^2 over the errors p of
    the robot's parameters and the poses of all places, with f_i the signed distance from the surface of touch i, r the
    tip's radius and P the prior. The factor, from 0 to 1, is chosen by leaving out one place after the other.

    References
    ----------
    .. [1] J. M. Hollerbach, W. Khalil, M. Gautier, "Model Identification", Springer Handbook of Robotics, 2nd ed. 2016.

    Examples
    --------
    >>> cell = tactfix.load_cell("samples/robot-calibration/cell.yaml")
    >>> touches = tactfix.load_touches("samples/robot-calibration/touches.csv", cell)
    >>> tactfix.calibrate(cell, touches)
    <Calibration: calibrated, 72 touches at 3 places, tip known to 6.1 before, 0.094 mm after>
    """
    return calibrated(cell.cell, touches, hold_out, unchecked)


def load_touches(source: Source, cell: CellFile) -> Touches:
    """Read the touches of a CSV file on the fixtures of a cell.

    Parameters
    ----------
    source : str, Path, bytes or open file
        With columns place, feature, q1 to qn; "-" for standard input.
    cell : CellFile
        Whose places and features are touched.

    Returns
    -------
    Touches
        In rad and the cell's units.

    Raises
    ------
    FileError
        With all problems, by row and line.

    Notes
    -----
    A line "# joints: deg" or "# joints: rad" above the header gives the unit of the joints.

    Examples
    --------
    >>> cell = tactfix.load_cell("samples/robot-calibration/cell.yaml")
    >>> touches = tactfix.load_touches("samples/robot-calibration/touches.csv", cell)
    >>> len(touches)
    72
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
    """Write the record of a locate as one HTML page that works offline, as `tactfix report` does.

    Parameters
    ----------
    fixture : Fixture
        What was touched.
    contacts : Contacts
        In base coordinates.
    result : LocateResult
        What `locate` found of these contacts.
    inputs : mapping of str to path, optional
        Files listed on the page with their checksums, by role, such as {"fixture": "plate.yaml"}.
    notes : mapping of str to str, optional
        Additional entries, such as {"operator": "Ada"}.

    Returns
    -------
    str
        The page.

    Raises
    ------
    MissingExtraError
        The extra report is not installed.
    FileError
        An input that cannot be read.

    Notes
    -----
    The scene is drawn by plotly, which is included in the page.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> contacts = tactfix.load_contacts("samples/robot-cell-plate/contacts.csv", fixture)
    >>> page = tactfix.html_report(fixture, contacts, tactfix.locate(fixture, contacts), notes={"operator": "Ada"})
    >>> "Ada" in page
    True
    """
    files = [InputFile(role, str(path), read_bytes(str(path))) for role, path in (inputs or {}).items()]
    record = Record(fixture, files, {}, datetime.now(UTC), dict(notes or {}))
    return locate_page(record, contacts, result, Judgement())
