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
"""No probe reaches farther from its flange: a longer offset is in another unit."""


@frozen_value
class LogContacts:
    """What a log says with the help of options: in units; tip_radius and sigma None where nothing says them.

    contacts: as the log has them, with the options' approaches, in the frame of the work offset. points (n, 3): with
    the tip's offset. tip_offset (3,): None where it is not given.
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
        """base_from_flange, or that of the tool (n, 3, 3); None where a contact has no pose."""
        found = [contact.rotation for contact in self.contacts if contact.rotation is not None]
        return np.array(found) if len(found) == len(self.contacts) else None


def load_log(
    format_name: str,
    source: Source,
    fixture: Fixture,
    options: ContactOptions | None = None,
    log_options: LogOptions | None = None,
) -> tuple[ContactFile, tuple[str, ...]]:
    """The contacts of a machine log in the fixture's units, and notes on what was dropped, passed over or overruled.

    Options beat the log, which beats the fixture's probe; the fixture's units do not stand in for those of the log,
    and its tip radius not for that of a format whose points may be compensated (xyzijk).

    Raises FileError with all that is wrong or missing; UsageError for options that do not fit the format.
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
    """What a machine log says, in the fixture's units, or in its own without a fixture; see load_log.

    complete: whether tip radius and sigma must be known.
    """
    said, wanted = options or ContactOptions(), log_options or LogOptions()
    log_format = find_format(format_name)
    name, text = read_log_text(source)
    problems: list[Problem] = []
    log = log_format.read(text, problems)
    units = said.units or log.units or "mm"  # none of all is a problem below
    contacts, repeated = last_of_each_place(log.contacts, units) if wanted.repeats == "last" else (log.contacts, ())
    dropped = (*log.notes, *repeated)
    _check_tip_offset(format_name, units, contacts, wanted.tip_offset)
    _check_features(contacts, dropped, wanted, fixture, problems)
    header = ContactOptions(units=log.units, tip_radius=_tip_radius(contacts, problems))
    if said.units is None and log.units is None:
        problems.append(
            Problem(
                f"{format_name} does not say its units", "give " + Setting.UNITS.to("mm") + ", or what the machine uses"
            )
        )
    settings = _settings(said, header, log_format, fixture)
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
        notes=(*dropped, *_overruled(said, header), *_frame_notes(log_format, contacts, wanted)),
    )


def _check_tip_offset(format_name: str, units: str, contacts: Sequence[LogContact], tip_offset: Vector | None) -> None:
    """A tip offset needs poses, and no tip is farther from the flange than a robot is long."""
    if tip_offset is None:
        return
    if any(contact.rotation is None for contact in contacts):
        raise UsageError(Setting.TIP_OFFSET.word + f" needs poses; {format_name} logs points")
    length = float(np.linalg.norm(tip_offset))
    if length * factor(units, "mm") > _MOST_TIP_MM:
        raise UsageError(
            Setting.TIP_OFFSET.word
            + f" is in the unit of the log: {length:g} {units} from the flange? write it in {units}, "
            + "as if it stood in the log"
        )


def find_format(format_name: str) -> LogFormat:
    """The machine log of this name; UsageError where there is none."""
    if format_name not in LOG_FORMATS:
        raise UsageError(
            f"no format of machine logs is called {format_name!r}; {did_you_mean(format_name, LOG_FORMATS)}"
        )
    return LOG_FORMATS[format_name]


def _settings(
    options: ContactOptions, header: ContactOptions, log_format: LogFormat, fixture: Fixture | None
) -> Settings:
    """What options, log and the fixture's probe say together.

    The probe's tip does not count where the log's points may be compensated. A unit that nothing says is a problem
    already; what it is then does not matter.
    """
    probe = Probe() if fixture is None else fixture.probe
    if log_format.compensated:
        probe = Probe(sigma=probe.sigma)
    said = replace(options, units=options.units or header.units or "mm")
    settings = settle(said, header, probe, fixture.units if fixture else None)
    assert settings is not None
    return settings


def _missing(settings: Settings) -> list[Problem]:
    """A problem for tip radius and sigma each, where nothing says it."""
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
    found, told = len(contacts), sum(run.count for run in runs)
    if not found:
        if not problems:
            problems.append(Problem("there are no contacts", "check the file and " + Setting.LOG_FORMAT.word))
    elif not runs:
        remedy = f"say which of the {found} contacts are on which, in order: " + Setting.FEATURES.to("bar:5,ball:4")
        problems.append(Problem("a machine log does not say which feature was touched", remedy))
    elif found != told and not problems:
        said = f" ({'; '.join(notes)})" if notes else ""
        problems.append(
            Problem(
                f"there are {found} contacts{said}, and features for {told}",
                "make " + Setting.FEATURES.word + " name each",
            )
        )


def _tip_radius(contacts: Sequence[LogContact], problems: list[Problem]) -> float | None:
    """The one tip radius that the log says; a problem where a line says another one."""
    said = [contact for contact in contacts if contact.tip_radius is not None]
    for contact in said:
        if contact.tip_radius != said[0].tip_radius:
            what = f"the tip radius is {contact.tip_radius:g}, in line {said[0].line} it is {said[0].tip_radius:g}"
            problems.append(Problem(what, "log the contacts of each tip in a file of their own", line=contact.line))
        elif contact.tip_radius is not None and contact.tip_radius < 0:
            problems.append(Problem("the tip radius is negative", "write 0 or more", line=contact.line))
    return said[0].tip_radius if said and (said[0].tip_radius or 0) >= 0 else None


def _points(contacts: Sequence[LogContact], tip_offset: Vector | None) -> Floats:
    """Points (n, 3) in the log's unit; with a tip offset, the tip's centre at the end of it."""
    points = np.array([contact.point for contact in contacts])
    if tip_offset is None:
        return points
    rotations = np.array([contact.rotation for contact in contacts])
    return np.asarray(points + rotations @ np.array(tip_offset))


def _approaches(contacts: Sequence[LogContact]) -> Floats:
    """Unit approaches (n, 3), nan where the log has none."""
    return np.array(
        [np.full(3, np.nan) if contact.approach is None else unit(contact.approach) for contact in contacts]
    )


def _overruled(options: ContactOptions, header: ContactOptions) -> tuple[str, ...]:
    """A note for each thing that the log says and an option says otherwise."""
    notes = []
    for word, said, option in (
        ("units", header.units, options.units),
        ("tip radius", header.tip_radius, options.tip_radius),
    ):
        if said is not None and option is not None and said != option:
            notes.append(f"the log says {word} {said}, the option says {option}: the option holds")
    return tuple(notes)


def _frame_notes(log_format: LogFormat, contacts: Sequence[LogContact], wanted: LogOptions) -> tuple[str, ...]:
    """What the results stand in, wherever the format leaves that open."""
    notes = []
    if log_format.frame and wanted.work_offset is None:
        notes.append(
            f"{log_format.name} reports in {log_format.frame}, and so stand the results; "
            f"a work offset takes them to the frame that it is written in"
        )
    if wanted.tip_offset is None and any(contact.rotation is not None for contact in contacts):
        notes.append(
            "the poses are taken as those of the tip's centre; for poses of the flange give the tip offset x,y,z"
        )
    return tuple(notes)
