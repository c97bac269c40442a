"""The report of design-check for people: findings with remedies, symmetries, contacts, accuracy, mistakes."""

from collections.abc import Iterator
from io import StringIO
from typing import Final

import numpy as np
from rich.console import Console, Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from tactfix.design.accuracy import Certainty, Influence
from tactfix.design.contact_counts import ContactCounts
from tactfix.design.design_report import DesignReport
from tactfix.design.findings import Severity
from tactfix.design.margins import Margins
from tactfix.design.random_layouts import LayoutStudy, RealPoses
from tactfix.localization.motion_words import vector

_CHECK_COLORS: Final[dict[Severity, str]] = {"ok": "green", "warning": "yellow", "error": "red"}
_MOST_SYMMETRIES: Final = 8
"""Rows of the table of symmetries."""
_SETS_LISTED: Final = 12
"""Minimal sets that are listed."""


def design_text(report: DesignReport, width: int = 100, *, color: bool = False) -> str:
    """The report as text, optionally with colour codes."""
    page = StringIO()
    console = Console(
        file=page, width=width, force_terminal=color, no_color=not color, highlight=False, legacy_windows=False
    )
    console.print(design_summary(report))
    return "".join(line.rstrip() + "\n" for line in page.getvalue().splitlines()).rstrip("\n") + "\n"


def design_summary(report: DesignReport) -> RenderableType:
    """The report as a rich renderable."""
    return Group(*(Padding(part, (0, 0, 1, 0)) for part in _parts(report)))


def _parts(report: DesignReport) -> Iterator[RenderableType]:
    yield Text.assemble((report.fixture.name, "bold"), "  ", (report.status, f"bold {_CHECK_COLORS[report.status]}"))
    yield _findings(report)
    if report.symmetries:
        yield _symmetries(report)
    yield _counts(report.counts)
    if report.counts.minimum_total == 6 and report.is_rigid:
        yield _sets(report)
    if report.study.shares:
        yield _shares(report.study)
    if report.certainty is not None:
        yield _certainty(report.certainty, report.fixture.units)
    if report.margins is not None:
        yield _margins(report.margins, report.fixture.units)
    if report.blind_spots:
        yield _blind_spots(report)


def _table(*headers: str, title: str) -> Table:
    return Table(*headers, title=title, title_justify="left", title_style="bold", box=None, header_style="dim")


def _findings(report: DesignReport) -> Table:
    table = Table("", "check", "finding", box=None, pad_edge=False, header_style="dim")
    for finding in sorted(report.findings, key=lambda f: ("error", "warning", "ok").index(f.status)):
        text = Text(finding.message)
        if finding.hint:
            text.append(f"\n> {finding.hint}", "cyan")
        table.add_row(Text(finding.status, _CHECK_COLORS[finding.status]), finding.code, text)
    return table


def _symmetries(report: DesignReport) -> Table:
    table = _table("broken by", "motion that maps the fixture onto itself", title="Symmetries")
    for symmetry in report.symmetries[:_MOST_SYMMETRIES]:
        breaker = Text(symmetry.broken_by or "nothing", "green" if symmetry.broken_by else "red")
        table.add_row(breaker, Text(symmetry.message))
    if len(report.symmetries) > _MOST_SYMMETRIES:
        table.add_row("", f"and {len(report.symmetries) - _MOST_SYMMETRIES} more")
    return table


def _counts(counts: ContactCounts) -> Table:
    table = _table(
        "feature", "alone", "radius unknown", "others located", "paper", "radius unknown",
        title="Fewest contacts on each feature",
    )  # fmt: skip
    each = counts.each
    for name in each.alone:
        row = (each.alone, each.alone_any_size, each.others_located, each.paper, each.paper_any_size)
        table.add_row(Text(name), *(str(column[name]) for column in row))
    return table


def _sets(report: DesignReport) -> Table:
    table = _table(
        "fewest contacts, all at once",
        "poses at most",
        "real ones seen, in random sets",
        title="Minimal sets, and poses they leave",
    )
    chosen = list(zip(report.counts.minimal_sets, report.pose_counts, report.real_poses, strict=True))
    for counts, poses, seen in chosen[:_SETS_LISTED]:
        names = " + ".join(f"{count} {name}" for name, count in counts.items() if count)
        table.add_row(Text(names), "" if poses is None else str(poses.complex_poses), _seen(seen))
    if len(chosen) > _SETS_LISTED:
        table.add_row(f"and {len(chosen) - _SETS_LISTED} more", "", "")
    return table


def _seen(seen: RealPoses | None) -> str:
    if seen is None:
        return "not tried"
    span = str(seen.most_seen) if seen.fewest_seen == seen.most_seen else f"{seen.fewest_seen} to {seen.most_seen}"
    return f"{span} in {seen.layouts}"


def _shares(study: LayoutStudy) -> Table:
    layouts = study.shares[0].layouts
    table = _table("contacts", "several poses", "a motion free", title=f"Of {layouts} random layouts are left with")
    for share in study.shares:
        table.add_row(str(share.contacts), f"{share.ambiguous:.0%}", f"{share.underdetermined:.0%}")
    return table


def _certainty(certainty: Certainty, units: str) -> Table:
    of = {"plan": "of the plan", "contacts": "of the contacts", "spread": "of well spread contacts"}[certainty.source]
    table = _table("", "", title=f"Accuracy {of} ({certainty.contacts})")
    table.show_header = False
    worst = certainty.worst
    best = min(certainty.extreme, key=lambda point: point.sigma)
    table.add_row("extreme points", f"{best.sigma:.3g} to {worst.sigma:.3g} {units} (1 sigma)")
    table.add_row("worst of them", f"{vector(worst.point)}, along {vector(worst.direction)}")
    for point in certainty.at:
        table.add_row(f"at {vector(point.point)}", f"{point.sigma:.3g} {units} along {vector(point.direction)}")
    table.add_row("worst motion", Text(certainty.weakest.message))
    table.add_row("matters most", Text(_influence(certainty.most, units)))
    table.add_row("matters least", Text(_influence(certainty.least, units)))
    indices = "  ".join(f"{name} {value:.3g}" for name, value in certainty.observability.indices.items())
    table.add_row("observability", indices)
    table.add_row("", f"rotations are multiplied by {certainty.observability.length:.4g} {units}")
    return table


def _influence(influence: Influence, units: str) -> str:
    without = influence.sigma_without
    then = "a motion is free" if without is None else f"worst point {without:.3g} {units}"
    point = vector(np.array(influence.point)).strip("()")
    return f"{influence.label} on {influence.feature} at ({point}); without it {then}"


def _margins(margins: Margins, units: str) -> Table:
    table = _table("", "", title="Margins")
    table.show_header = False
    rival = margins.rival
    if rival is None:
        table.add_row("nearest wrong pose", f"more than {margins.reach:.0f} sigma behind the right one")
    else:
        table.add_row("nearest wrong pose", f"{rival.words} the right one, {rival.shift:.3g} {units} away")
    for fragile in margins.fragile:
        then = "a motion is free" if fragile.outcome == "free" else "a second pose is left"
        table.add_row("must not be lost", Text(f"{fragile.label} on {fragile.feature}: without it {then}"))
    if margins.losses and not margins.fragile:
        table.add_row("must not be lost", f"none: each of {margins.losses} contacts was left out in turn")
    return table


def _blind_spots(report: DesignReport) -> Table:
    table = _table("mistake", "shown", f"pose off {report.fixture.units}", "", title="Mistakes, each at its worst")
    table.columns[0].no_wrap = True
    for spot in report.blind_spots:
        shown = Text("yes", "green") if spot.detectable else Text(f"{spot.power:.0%}", "red")
        off = "no pose" if spot.pose_shift is None else f"{spot.pose_shift:.3g}"
        table.add_row(spot.error, shown, off, Text(spot.message.rsplit(": ", 1)[0]))
    return table
