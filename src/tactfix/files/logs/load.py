"""Contacts from a machine log, with options for what the format does not contain; nothing is guessed."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import FileError, Problem, UsageError
from tactfix.files.contact_file import ContactFile
from tactfix.files.contact_options import EVERY, ContactOptions, LogOptions, Settings, Vector, settle
from tactfix.files.logs import LOG_FORMATS
from tactfix.files.logs.log import LogContact, LogFormat, in_base, last_of_each_place, vector, with_approaches
from tactfix.files.reading import Source, read_log_text
from tactfix.fixture import Fixture, Probe
from tactfix.geometry.arrays import Floats, unit
from tactfix.settings import Setting
from tactfix.units import factor
from tactfix.values import frozen_value
from tactfix.wording import did_you_mean

_MOST_TIP_MM = 3000.0
"""Upper limit of the length of a tip offset: a longer one is taken to be in the wrong unit."""


@frozen_value
class LogContacts:
    """The contacts of a log and their settings, in units; tip_radius and sigma are None if not given.

    contacts: in the log's unit, with the approaches of the options, in the frame of the work offset. points (n, 3):
    with the tip offset applied. tip_offset (3,): in the flange frame, None if not given.
    """

    name: str
    units: str
    format_name: str
    contacts: tuple[LogContact, ...]
    features: tuple[str, ...]
    points: Floats
    approaches: Floats
    tip_radius: float | None
    sigma: float | None
    tip_offset: Vector | None
    notes: tuple[str, ...]

    @property
    def rotations(self) -> Floats | None:
        """Rotations base_from_flange or base_from_tool (n, 3, 3); None if any contact has no pose."""
        found = [contact.rotation for contact in self.contacts if contact.rotation is not None]
        return np.array(found) if len(found) == len(self.contacts) else None


def load_log(
    format_name: str,
    source: Source,
    fixture: Fixture,
    options: ContactOptions | None = None,
    log_options: LogOptions | None = None,
) -> tuple[ContactFile, tuple[str, ...]]:
    """The contacts of a machine log in the fixture's units, and notes on what was dropped, skipped or overridden.

    Options take precedence over the log, and the log over the fixture's probe. The fixture's units are no default for
    those of the log, nor its tip radius for a format whose points may be tip-compensated (xyzijk).

    Raises FileError with every problem of the log; UsageError for options that do not fit the format.
    """
    read = read_log(format_name, source, fixture, options, log_options, complete=True)
    assert read.tip_radius is not None
    assert read.sigma is not None
    contacts = Contacts(
        features=read.features,
        points=read.points,
        approaches=read.approaches,
        sigmas=np.full(len(read.features), read.sigma),
        tip_radius=read.tip_radius,
        rows=tuple(range(1, len(read.features) + 1)),
        ids=tuple(contact.id for contact in read.contacts),
        flange_rotations=read.rotations,
        tip_offset=None if read.tip_offset is None else np.array(read.tip_offset),
        units=read.units,
    )
    return ContactFile(read.name, contacts, read.units), read.notes


def read_log(
    format_name: str,
    source: Source,
    fixture: Fixture | None,
    options: ContactOptions | None,
    log_options: LogOptions | None,
    *,
    complete: bool,
) -> LogContacts:
    """The contacts of a machine log in the fixture's units, without a fixture in its own; see load_log.

    complete: whether a missing tip radius or sigma is a problem.
    """
    chosen, wanted = options or ContactOptions(), log_options or LogOptions()
    log_format = find_format(format_name)
    name, text = read_log_text(source)
    problems: list[Problem] = []
    log = log_format.read(text, problems)
    units = chosen.units or log.units or "mm"  # if neither gives it, a problem is added below
    contacts, repeated = last_of_each_place(log.contacts, units) if wanted.repeats == "last" else (log.contacts, ())
    dropped = (*log.notes, *repeated)
    _check_tip_offset(format_name, units, contacts, wanted.tip_offset)
    _check_features(contacts, dropped, wanted, fixture, problems)
    header = ContactOptions(units=log.units, tip_radius=_tip_radius(contacts, problems))
    if chosen.units is None and log.units is None:
        problems.append(
            Problem(
                f"{format_name} does not say its units", "give " + Setting.UNITS.to("mm") + ", or what the machine uses"
            )
        )
    settings = _settings(chosen, header, log_format, fixture)
    if complete:
        problems.extend(_missing(settings))
    if problems:
        raise FileError(name, problems)
    features = tuple(run.feature for run in wanted.features for _ in range(run.count))
    contacts = with_approaches(contacts, features, wanted.approaches)
    if wanted.work_offset is not None:
        contacts = in_base(contacts, wanted.work_offset.pose(units))
    return LogContacts(
        name=name,
        units=settings.target_units,
        format_name=format_name,
        contacts=contacts,
        features=features,
        points=_points(contacts, wanted.tip_offset) * settings.scale,
        approaches=_approaches(contacts),
        tip_radius=settings.tip_radius,
        sigma=settings.sigma,
        tip_offset=None if wanted.tip_offset is None else vector([x * settings.scale for x in wanted.tip_offset]),
        notes=(*dropped, *_overruled(chosen, header), *_frame_notes(log_format, contacts, wanted)),
    )


def _check_tip_offset(format_name: str, units: str, contacts: Sequence[LogContact], tip_offset: Vector | None) -> None:
    """A tip offset needs poses; a length that no robot has means a wrong unit."""
    if tip_offset is None:
        return
    if any(contact.rotation is None for contact in contacts):
        raise UsageError(Setting.TIP_OFFSET.word + f" needs poses; {format_name} logs points")
    length = float(np.linalg.norm(tip_offset))
    if length * factor(units, "mm") > _MOST_TIP_MM:
        raise UsageError(
            Setting.TIP_OFFSET.word
            + f" is in the unit of the log: {length:g} {units} from the flange? write it in {units}, "
            + "as if it were in the log"
        )


def find_format(format_name: str) -> LogFormat:
    """The log format of this name; UsageError if there is none."""
    if format_name not in LOG_FORMATS:
        raise UsageError(
            f"no format of machine logs is called {format_name!r}; {did_you_mean(format_name, LOG_FORMATS)}"
        )
    return LOG_FORMATS[format_name]


def _settings(
    options: ContactOptions, header: ContactOptions, log_format: LogFormat, fixture: Fixture | None
) -> Settings:
    """The settings that follow from options, log and the fixture's probe.

    The probe's tip radius is ignored if the log's points may be tip-compensated. A missing unit has been reported
    already, so any unit will do.
    """
    probe = Probe() if fixture is None else fixture.probe
    if log_format.compensated:
        probe = Probe(sigma=probe.sigma)
    completed = replace(options, units=options.units or header.units or "mm")
    settings = settle(completed, header, probe, fixture.units if fixture else None)
    assert settings is not None
    return settings


def _missing(settings: Settings) -> list[Problem]:
    """A problem for each of tip radius and sigma that is not given."""
    problems = []
    if settings.tip_radius is None:
        remedy = (
            "give " + Setting.TIP_RADIUS.to(0) + " for points of the surface, or the radius of the tip for its centres"
        )
        problems.append(Problem("the tip radius is not given", remedy))
    if settings.sigma is None:
        remedy = "give " + Setting.SIGMA.word + ", one standard deviation of a contact"
        problems.append(Problem("the sigma of a contact is not given", remedy))
    return problems


def _check_features(
    contacts: Sequence[LogContact],
    notes: Sequence[str],
    wanted: LogOptions,
    fixture: Fixture | None,
    problems: list[Problem],
) -> None:
    """Every contact must have a feature, and every feature must be one of the fixture's."""
    runs = wanted.features
    for run in runs:
        if fixture is not None and run.feature not in fixture.features:
            hint = did_you_mean(run.feature, fixture.features)
            raise UsageError(
                Setting.FEATURES.word + f" names {run.feature!r}, a feature that {fixture.name} does not have; {hint}"
            )
    for feature, _ in wanted.approaches:
        if feature != EVERY and feature not in {run.feature for run in runs}:
            raise UsageError(Setting.APPROACH.word + f" names {feature!r}, which is none of " + Setting.FEATURES.word)
    found, assigned = len(contacts), sum(run.count for run in runs)
    if not found:
        if not problems:
            problems.append(Problem("there are no contacts", "check the file and " + Setting.LOG_FORMAT.word))
    elif not runs:
        remedy = f"say which of the {found} contacts are on which, in order: " + Setting.FEATURES.to("bar:5,ball:4")
        problems.append(Problem("a machine log does not say which feature was touched", remedy))
    elif found != assigned and not problems:
        remarks = f" ({'; '.join(notes)})" if notes else ""
        problems.append(
            Problem(
                f"there are {found} contacts{remarks}, and features for {assigned}",
                "make " + Setting.FEATURES.word + " name each",
            )
        )


def _tip_radius(contacts: Sequence[LogContact], problems: list[Problem]) -> float | None:
    """The tip radius of the log, in its unit; a problem for each line with a different one."""
    with_radius = [contact for contact in contacts if contact.tip_radius is not None]
    for contact in with_radius:
        if contact.tip_radius != with_radius[0].tip_radius:
            first = with_radius[0]
            message = f"the tip radius is {contact.tip_radius:g}, in line {first.line} it is {first.tip_radius:g}"
            problems.append(Problem(message, "log the contacts of each tip in a file of their own", line=contact.line))
        elif contact.tip_radius is not None and contact.tip_radius < 0:
            problems.append(Problem("the tip radius is negative", "write 0 or more", line=contact.line))
    return with_radius[0].tip_radius if with_radius and (with_radius[0].tip_radius or 0) >= 0 else None


def _points(contacts: Sequence[LogContact], tip_offset: Vector | None) -> Floats:
    """Points (n, 3) in the log's unit; with a tip offset, the tip centres."""
    points = np.array([contact.point for contact in contacts])
    if tip_offset is None:
        return points
    rotations = np.array([contact.rotation for contact in contacts])
    return np.asarray(points + rotations @ np.array(tip_offset))


def _approaches(contacts: Sequence[LogContact]) -> Floats:
    """Unit approaches (n, 3); nan for a contact without one."""
    return np.array(
        [np.full(3, np.nan) if contact.approach is None else unit(contact.approach) for contact in contacts]
    )


def _overruled(options: ContactOptions, header: ContactOptions) -> tuple[str, ...]:
    """A note for each setting of the log that an option overrides."""
    notes = []
    for word, logged, option in (
        ("units", header.units, options.units),
        ("tip radius", header.tip_radius, options.tip_radius),
    ):
        if logged is not None and option is not None and logged != option:
            notes.append(f"the log says {word} {logged}, the option says {option}: the option is used")
    return tuple(notes)


def _frame_notes(log_format: LogFormat, contacts: Sequence[LogContact], wanted: LogOptions) -> tuple[str, ...]:
    """Notes on the frame of the results if the format does not fix it."""
    notes = []
    if log_format.frame and wanted.work_offset is None:
        notes.append(
            f"{log_format.name} reports in {log_format.frame}, and so are the results; "
            f"a work offset takes them to the frame that it is written in"
        )
    if wanted.tip_offset is None and any(contact.rotation is not None for contact in contacts):
        notes.append(
            "the poses are taken as those of the tip's centre; for poses of the flange give the tip offset x,y,z"
        )
    return tuple(notes)
