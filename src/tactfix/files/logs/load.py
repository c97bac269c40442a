"""Contacts from a machine log: what the format cannot say, options must; nothing is guessed."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import FileError, Problem, UsageError
from tactfix.files.contact_file import ContactFile
from tactfix.files.contact_options import ContactOptions, Settings, settle
from tactfix.files.logs import LOG_FORMATS
from tactfix.files.logs.log import Log, LogContact, LogFormat, Vector
from tactfix.files.logs.source import read_log_text
from tactfix.files.reading import Source, composed
from tactfix.fixture import Fixture, Probe
from tactfix.geometry.arrays import Floats, unit
from tactfix.wording import did_you_mean

_MOST_PROBLEMS = 20


@dataclass(frozen=True, slots=True)
class FeatureRun:
    """count contacts in a row on one feature."""

    feature: str
    count: int


@dataclass(frozen=True, slots=True, eq=False)
class LogContacts:
    """What a log says with the help of options: in units; tip_radius and sigma None where nothing says them."""

    name: str
    units: str
    log: Log
    features: tuple[str, ...]
    points: Floats
    approaches: Floats
    tip_radius: float | None
    sigma: float | None
    notes: tuple[str, ...]


def parse_features(text: str) -> tuple[FeatureRun, ...]:
    """'bar:5,ball:3' as five contacts on bar, then three on ball; UsageError for anything else."""
    runs = []
    for part in composed(text).split(","):
        match = re.fullmatch(r"\s*(.+?)\s*:\s*(\d+)\s*", part)
        if match is None or int(match.group(2)) == 0:
            raise UsageError(f"--features {text!r}: {part.strip()!r} is not NAME:COUNT; write bar:5,ball:3, in order")
        runs.append(FeatureRun(match.group(1), int(match.group(2))))
    return tuple(runs)


def load_log(
    format_name: str,
    source: Source,
    fixture: Fixture,
    options: ContactOptions | None = None,
    features: Sequence[FeatureRun] = (),
    tip_offset: Vector | None = None,
) -> tuple[ContactFile, tuple[str, ...]]:
    """The contacts of a machine log in the fixture's units, and notes on what was dropped, passed over or overruled.

    Options beat the log, which beats the fixture's probe; the fixture's units do not stand in for those of the log,
    and its tip radius not for that of a format whose points may be compensated (xyzijk). tip_offset: the tip's centre
    in the frame of the poses, in the log's unit, for logs of flange poses.

    Raises FileError with all that is wrong or missing; UsageError for options that do not fit the format.
    """
    read = read_log(format_name, source, fixture, options or ContactOptions(), features, tip_offset, complete=True)
    assert read.tip_radius is not None
    assert read.sigma is not None
    contacts = Contacts(
        features=read.features,
        points=read.points,
        approaches=read.approaches,
        sigmas=np.full(len(read.features), read.sigma),
        tip_radius=read.tip_radius,
        rows=tuple(range(1, len(read.features) + 1)),
        ids=tuple(contact.id for contact in read.log.contacts),
    )
    return ContactFile(read.name, contacts, read.units), read.notes


def read_log(
    format_name: str,
    source: Source,
    fixture: Fixture | None,
    options: ContactOptions,
    features: Sequence[FeatureRun],
    tip_offset: Vector | None,
    *,
    complete: bool,
) -> LogContacts:
    """What a machine log says, in the fixture's units, or in its own without a fixture; see load_log.

    complete: whether tip radius and sigma must be known.
    """
    log_format = _find(format_name)
    name, text = read_log_text(source)
    problems: list[Problem] = []
    log = log_format.read(text, problems)
    if tip_offset is not None and any(contact.rotation is None for contact in log.contacts):
        raise UsageError(f"--tip-offset needs poses; {format_name} logs points")
    _check_features(name, log, features, fixture, problems)
    header = ContactOptions(units=log.units, tip_radius=_tip_radius(log, problems))
    if options.units is None and log.units is None:
        problems.append(Problem(f"{format_name} does not say its units", "give --units mm, or what the machine uses"))
    settings = _settings(options, header, log_format, fixture)
    if complete:
        problems.extend(_missing(settings))
    if problems:
        raise FileError(name, _shortened(problems))
    return LogContacts(
        name=name,
        units=settings.target_units,
        log=log,
        features=tuple(run.feature for run in features for _ in range(run.count)),
        points=_points(log.contacts, tip_offset) * settings.scale,
        approaches=_approaches(log.contacts),
        tip_radius=settings.tip_radius,
        sigma=settings.sigma,
        notes=(*log.notes, *_overruled(options, header), *_frame_note(log, tip_offset)),
    )


def _find(format_name: str) -> LogFormat:
    if format_name not in LOG_FORMATS:
        raise UsageError(f"{format_name!r} is no machine log that is known; there are {', '.join(LOG_FORMATS)}")
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
        remedy = "give --tip-radius: 0 for points of the surface, the tip's radius for its centres"
        problems.append(Problem("nothing says the tip radius", remedy))
    if settings.sigma is None:
        remedy = "give --sigma, one standard deviation of a contact"
        problems.append(Problem("nothing says the sigma of a contact", remedy))
    return problems


def _check_features(
    name: str, log: Log, runs: Sequence[FeatureRun], fixture: Fixture | None, problems: list[Problem]
) -> None:
    """Every contact must have a feature, and every feature must be one of the fixture's."""
    for run in runs:
        if fixture is not None and run.feature not in fixture.features:
            hint = did_you_mean(run.feature, fixture.features)
            raise UsageError(f"--features: {name} cannot touch {run.feature!r}: there is no such feature; {hint}")
    found, told = len(log.contacts), sum(run.count for run in runs)
    if not found and not problems:
        problems.append(Problem("there are no contacts", "check the file and --contacts-format"))
    elif not runs:
        remedy = f"say which of the {found} contacts are on which, in order: --features bar:5,ball:4"
        problems.append(Problem("a machine log does not say which feature was touched", remedy))
    elif found != told and not problems:
        notes = f" ({'; '.join(log.notes)})" if log.notes else ""
        problems.append(Problem(f"there are {found} contacts{notes}, --features names {told}", "make them agree"))


def _tip_radius(log: Log, problems: list[Problem]) -> float | None:
    """The one tip radius that the log says; a problem where a line says another one."""
    said = [contact for contact in log.contacts if contact.tip_radius is not None]
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
    """Unit approaches (n, 3), nan where the log tells none."""
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


def _frame_note(log: Log, tip_offset: Vector | None) -> tuple[str, ...]:
    if tip_offset is None and any(contact.rotation is not None for contact in log.contacts):
        return ("the poses are taken as those of the tip's centre; for poses of the flange give --tip-offset x,y,z",)
    return ()


def _shortened(problems: Sequence[Problem]) -> list[Problem]:
    """No more problems than a person reads."""
    more = len(problems) - _MOST_PROBLEMS
    if more <= 0:
        return list(problems)
    return [*problems[:_MOST_PROBLEMS], Problem(f"{more} more problems", "mend the ones above first")]
