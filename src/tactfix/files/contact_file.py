"""Contact files: reads CSV as contacts in the fixture's units, or reports every problem of the file."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import FileError, Problem
from tactfix.files.contact_header import APPROACH_COLUMNS, ORIENTATION_COLUMNS, Header, read_header
from tactfix.files.contact_options import ContactOptions, Settings, settle
from tactfix.files.contact_table import Table, decimal_mark, directions, numbers, own_sigmas, read_table
from tactfix.files.flange_columns import flange_rotations
from tactfix.files.reading import FIXTURE_FIRST, NO_FIXTURE, Source, lines_of, read_source
from tactfix.fixture import Fixture, Probe
from tactfix.geometry.arrays import Floats
from tactfix.settings import Setting
from tactfix.units import LEAST_LENGTH, MOST_LENGTH
from tactfix.values import frozen_value
from tactfix.wording import did_you_mean

_SIGMA_HINT: Final = (
    "one standard deviation of a contact, for a measuring machine about 0.001 mm, a machine tool 0.003 to 0.005, "
    "a robot with a touch probe 0.05 to 0.1, with a welding wire 0.25; tactfix qualify measures it"
)
SURFACE: Final = "surface"
"""Name of the single feature of a file without a feature column, read without a fixture."""


@frozen_value
class ContactFile:
    """The content of a contact file: its name for messages, its contacts, their unit, and the target of each."""

    name: str
    contacts: Contacts
    units: str
    targets: tuple[str, ...] | None = None


def read_contact_file(
    source: Source, fixture: Fixture | None = None, options: ContactOptions | None = None
) -> ContactFile:
    """The contacts of a CSV file.

    source: a path, "-" for standard input, bytes, or an open file. fixture: the touched fixture; lengths are converted
    to its units. Without a fixture they keep the file's unit, and all contacts of a file without a feature column are
    on one feature, "surface". options override the file's header, and the header the fixture's probe.

    Raises FileError with every problem, by row and line.
    """
    name, text = read_source(source)
    problems: list[Problem] = []
    file = _read(name, text, fixture, options or ContactOptions(), problems)
    if file is None or problems:
        raise FileError(name, sorted(problems, key=lambda problem: problem.line or 0))
    return file


def _read(
    name: str, text: str, fixture: Fixture | None, options: ContactOptions, problems: list[Problem]
) -> ContactFile | None:
    lines = lines_of(text)
    if _is_fixture(lines):
        problems.append(Problem("this is a fixture file", NO_FIXTURE if fixture is None else FIXTURE_FIRST))
        return None
    header = read_header(lines, problems, feature_needed=fixture is not None)
    if header is None:
        return None
    table = read_table(lines, header, problems)
    if table is None:
        return None
    numeric = [name for name in header.columns if name not in ("feature", "id", "target")]
    table = replace(table, decimal=decimal_mark(table, numeric, problems))
    settings = _settle(options, header, fixture, table, problems)
    features = _features(table, fixture, problems)
    problems += _tip_problems(options, header, fixture, settings, features)
    points = numbers(table, ("x", "y", "z"), problems)
    flanges = flange_rotations(table, problems)
    approaches = _approaches(table, flanges, problems)
    sigmas = own_sigmas(table, problems)
    if problems or settings is None or settings.tip_radius is None:
        return None
    with np.errstate(over="ignore"):
        points, sigmas = points * settings.scale, sigmas * settings.scale
    if header.settings.of_flange and flanges is not None and settings.tip_offset is not None:
        points = points + flanges @ np.array(settings.tip_offset)
    for index in np.flatnonzero(~(np.abs(points) <= MOST_LENGTH).all(axis=1)):
        problems.append(table.problem(int(index), "too far away for a number", "check the coordinates and the units"))
    for index in np.flatnonzero((sigmas < LEAST_LENGTH) | (sigmas > MOST_LENGTH)):
        message = f"sigma is {table.columns['sigma'][int(index)]}, which is no length"
        problems.append(table.problem(int(index), message, "write the standard deviation of a contact, such as 0.005"))
    contacts = Contacts(
        features=features,
        points=points,
        approaches=approaches,
        sigmas=np.where(np.isnan(sigmas), settings.sigma or np.nan, sigmas),
        tip_radius=settings.tip_radius,
        rows=tuple(table.rows),
        ids=tuple(cell or None for cell in table.columns["id"]) if "id" in table.columns else (None,) * len(table),
        flange_rotations=flanges,
        tip_offset=None if settings.tip_offset is None else np.array(settings.tip_offset),
        units=settings.target_units,
    )
    targets = tuple(table.columns["target"]) if "target" in table.columns else None
    return ContactFile(name, contacts, settings.target_units, targets)


def _is_fixture(lines: Sequence[str]) -> bool:
    """Whether the text begins like a fixture file, given in place of the contact file."""
    first = next((line for line in lines if line.strip() and not line.startswith("#")), "")
    return first.replace(" ", "").startswith("tactfix:")


def _settle(
    options: ContactOptions, header: Header, fixture: Fixture | None, table: Table, problems: list[Problem]
) -> Settings | None:
    """The settings; a problem for each of units, tip radius and sigma that is not given."""
    probe, units = (fixture.probe, fixture.units) if fixture else (Probe(), None)
    settings = settle(options, header.settings, probe, units)
    if settings is None:
        if "units" not in header.setting_keys:
            problems.append(
                Problem(
                    "the units are not given", "write '# units: mm' above the header, or give " + Setting.UNITS.to("mm")
                )
            )
        settings = settle(replace(options, units="mm"), header.settings, probe, units)
    assert settings is not None
    if "tip-radius" in options.unknown and settings.tip_radius is None:
        settings = replace(settings, tip_radius=0.0)
    problems += _flange_problems(options, header, settings)
    if settings.tip_radius is None and "tip_radius" not in header.setting_keys:
        remedy = (
            "write '# tip_radius: 0' above the header if these are points of the surface, "
            "or the radius of the tip if they are its centres, or give " + Setting.TIP_RADIUS.word
        )
        problems.append(Problem("the tip radius is not given", remedy))
    if settings.sigma is None and "sigma" not in header.setting_keys and not all(table.columns.get("sigma", ("",))):
        remedy = "write '# sigma: ...' above the header, or give " + Setting.SIGMA.word + f": {_SIGMA_HINT}"
        problems.append(Problem("the sigma of a contact is not given", remedy))
    return settings


def _flange_problems(options: ContactOptions, header: Header, settings: Settings) -> Iterator[Problem]:
    """Problems if the points need a flange orientation or a tip offset that is not given."""
    has_orientation = any(names[0] in header.columns for names in ORIENTATION_COLUMNS)
    is_given = options.tip_offset is not None or header.settings.tip_offset is not None
    wants = "a tip offset is given" if is_given else ""
    wants = (
        "pose is flange" if header.settings.of_flange else "the tip is unknown" if "tip" in options.unknown else wants
    )
    if wants and not has_orientation:
        remedy = (
            "add it in one convention: qw, qx, qy, qz; rx, ry, rz (rad); a, b, c (KUKA) or w, p, r (Fanuc), degrees"
        )
        yield Problem(f"{wants}, and no column gives the orientation of the flange", remedy)
    is_missing = (
        settings.tip_offset is None and "tip_offset" not in header.setting_keys and "tip" not in options.unknown
    )
    if header.settings.of_flange and is_missing:
        given = Setting.TIP_OFFSET.word + " or " + Setting.UNKNOWN.to("tip")
        remedy = "write '# tip_offset: x, y, z' (flange frame) above the header, or give " + given
        yield Problem("pose is flange, and the tip offset is not given", remedy)


def _tip_problems(
    options: ContactOptions,
    header: Header,
    fixture: Fixture | None,
    settings: Settings | None,
    features: Sequence[str],
) -> Iterator[Problem]:
    """A problem if the tip given by file or option does not fit into a bore: the unit may be wrong."""
    given = header.settings.tip_radius if options.tip_radius is None else options.tip_radius
    if fixture is None or settings is None or given is None or "tip-radius" in options.unknown:
        return
    touched = [fixture.features[name] for name in set(features) if name in fixture.features]
    bores = [(one.radius, one.name) for one in touched if one.side == "inner" and one.radius is not None]
    radius, name = min(bores, default=(np.inf, ""))
    tip, units, units_of_file = given * settings.scale, settings.target_units, settings.units
    if tip >= radius:
        in_file = "" if units_of_file == units else f" ({given:g} {units_of_file})"
        message = (
            f"a tip of radius {tip:g} {units}{in_file} does not fit into {name}, a bore of radius {radius:g} {units}"
        )
        remedy = f"check tip_radius, and the radius and side of {name}"
        unit = f"'# units: {units_of_file}'" if options.units is None else Setting.UNITS.to(units_of_file)
        yield Problem(message, "is " + unit + " right? else " + remedy if in_file else remedy)


def _features(table: Table, fixture: Fixture | None, problems: list[Problem]) -> tuple[str, ...]:
    """The feature of each contact; a problem for each name that the fixture does not have."""
    if "feature" not in table.columns:
        return (SURFACE,) * len(table)
    names = tuple(table.columns["feature"])
    unknown = {name for name in set(names) if not name or (fixture is not None and name not in fixture.features)}
    if unknown:
        for index, name in enumerate(names):
            if name in unknown:
                message = f"there is no feature {name!r}" if name else "feature is empty"
                remedy = did_you_mean(name, fixture.features if fixture else ()) if name else "name the feature touched"
                problems.append(table.problem(index, message, remedy))
    return names


def _approaches(table: Table, flanges: Floats | None, problems: list[Problem]) -> Floats:
    """Unit approaches (n, 3) in base from ax, ay, az; -(nx, ny, nz); or fx, fy, fz; nan for a row without one.

    flanges (n, 3, 3): base_from_flange.
    """
    names, vectors = directions(table, APPROACH_COLUMNS, problems)
    if names[:1] == ("fx",) and flanges is not None:
        return np.asarray((flanges @ vectors[:, :, None])[:, :, 0])
    return -vectors if names[:1] == ("nx",) else vectors
