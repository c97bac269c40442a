"""Findings of design-check on a fixture's geometry, each with a code, a severity, a message and a hint."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Literal, TypeAlias

import numpy as np

from tactfix.design.contact_counts import ContactCounts
from tactfix.design.remedies import feature_remedy, relabelling_remedy, symmetry_remedy
from tactfix.design.symmetries import Symmetry
from tactfix.design.touch_regions import regions_meet
from tactfix.fixture import Fixture
from tactfix.geometry.surfaces import Surface
from tactfix.results import FreeMotion
from tactfix.values import frozen_value
from tactfix.wording import listed

Severity: TypeAlias = Literal["ok", "warning", "error"]


@frozen_value(eq=True)
class Finding:
    """One finding. code: its name for `--explain`; hint: what to do about it, empty if nothing is."""

    code: str
    status: Severity
    message: str
    hint: str = ""


def worst(findings: Sequence[Finding]) -> Severity:
    """The severity of the gravest finding."""
    statuses = {finding.status for finding in findings}
    return "error" if "error" in statuses else "warning" if "warning" in statuses else "ok"


def motion_findings(
    motions: Sequence[FreeMotion], weak: Sequence[FreeMotion], surfaces: Mapping[str, Surface]
) -> Iterator[Finding]:
    """Free motions, and motions that are constrained by an offset of a few sigma only."""
    for motion in motions:
        yield Finding(
            "free_motion",
            "error",
            f"no contact on these features removes this motion: {motion.message}",
            feature_remedy(motion, surfaces),
        )
    if not motions:
        yield Finding("free_motion", "ok", "no motion is common to all features")
    reported = {motion.message for motion in motions}
    for motion in weak:
        if motion.message not in reported:
            yield Finding(
                "weak_motion",
                "warning",
                f"a motion is determined only by an offset of less than ten sigma: {motion.message}",
                f"make the offset larger; {feature_remedy(motion, surfaces)}",
            )


def symmetry_findings(
    found: Sequence[Symmetry],
    near: Sequence[Symmetry],
    fixture: Fixture,
    surfaces: Mapping[str, Surface],
    near_ratio: float,
    is_unique: bool,
) -> Iterator[Finding]:
    """Symmetries that are unbroken or broken in part, and interchangeable features.

    near: symmetries to within ten sigma, near_ratio of the fixture's size, that are not exact; is_unique: the given
    contacts leave one pose only.
    """
    unbroken = [symmetry for symmetry in found if symmetry.broken_by is None]
    for symmetry in unbroken:
        hint = symmetry_remedy(symmetry, surfaces, fixture.touch)
        if symmetry.partly:
            yield Finding(
                "symmetry_overlap",
                "warning" if is_unique else "error",
                f"the {symmetry.message} maps the fixture onto itself, and the touch box of {listed(symmetry.partly)} "
                "breaks it only in part: contacts that the motion keeps in the box do not distinguish the two poses",
                hint,
            )
        else:
            yield Finding(
                "symmetry",
                "error",
                f"the {symmetry.message} maps the fixture onto itself: nothing distinguishes the two poses",
                hint,
            )
    if not unbroken:
        yield Finding("symmetry", "ok", _broken(found))
    for symmetry in (*found, *near):
        if symmetry.broken_by == "placement":
            yield Finding(
                "symmetry_placement",
                "warning",
                f"only the placement breaks the {symmetry.message}, which maps the fixture onto itself: a fixture "
                "mounted that way would be located wrongly",
                f"make sure that it cannot be mounted that way; or "
                f"{symmetry_remedy(symmetry, surfaces, fixture.touch)}",
            )
    if any(symmetry.confusable for symmetry in (*found, *near)):
        hint = relabelling_remedy(surfaces, fixture.touch, near_ratio)
        yield from _equal_features(found, "exactly", hint)
        yield from _equal_features(near, "to within ten sigma", hint)
    for symmetry in near:
        if symmetry.broken_by is None:
            yield Finding(
                "near_symmetry",
                "warning",
                f"the {symmetry.message} maps the fixture onto itself to within ten sigma",
                symmetry_remedy(symmetry, surfaces, fixture.touch),
            )


def _broken(found: Sequence[Symmetry]) -> str:
    """The number of symmetries by what breaks them."""
    if not found:
        return "no motion maps the fixture onto itself"
    by = {way: sum(s.broken_by == way for s in found) for way in ("labels", "approach", "touch", "placement")}
    ways = [f"{count} by {way}" for way, count in by.items() if count]
    return f"all symmetries are broken: {', '.join(ways)}"


def _equal_features(found: Sequence[Symmetry], how: str, hint: str) -> Iterator[Finding]:
    groups = dict.fromkeys(tuple(n for n, image in s.images.items() if n != image) for s in found if s.confusable)
    for names in groups:
        yield Finding(
            "equal_features",
            "warning",
            f"{listed(names)} are interchangeable {how}: contacts with exchanged labels still fit",
            hint,
        )


def touch_findings(
    fixture: Fixture, surfaces: Mapping[str, Surface], unreachable: Sequence[str], size: float
) -> Iterator[Finding]:
    """Features that cannot be touched inside their touch boxes."""
    for name, box in fixture.touch.items():
        if name in surfaces and not regions_meet(surfaces[name], box, box, np.eye(4), size):
            yield Finding(
                "touch_box",
                "error",
                f"the touch box of {name} does not meet its surface",
                f"correct the limits of touch: {name} (fixture frame, {fixture.units})",
            )
        elif name in unreachable:
            yield _blocked(name)
    yield from (_blocked(name) for name in unreachable if name not in fixture.touch)


def _blocked(name: str) -> Finding:
    return Finding(
        "touch_box",
        "error",
        f"{name} cannot be touched: other features block every straight approach, or its box is too small",
        "enlarge its touch box, limit those of the features in the way, or give probe: approach_distance",
    )


def count_findings(counts: ContactCounts, is_rigid: bool) -> Iterator[Finding]:
    """The fewest contacts."""
    if not is_rigid:
        need = ", ".join(f"{name} {count}" for name, count in counts.each.alone.items())
        yield Finding(
            "relations_incomplete",
            "warning",
            "the known distances and angles do not make the features one rigid body; "
            f"each needs contacts that locate it alone: {need}",
            "add the missing relations, or give every feature its place: then fewer contacts suffice, with more checks",
        )
        return
    shown = counts.minimal_sets[:4]
    sets = "; ".join(" + ".join(f"{n} {name}" for name, n in chosen.items() if n) for chosen in shown)
    left = len(counts.minimal_sets) - len(shown)
    more = f"; and {left} more" if left else ""
    total = f"{counts.minimum_total} contacts" if counts.complete else f"{counts.minimum_total} contacts, in many ways"
    yield Finding("contacts", "ok", f"at least {total}: {sets}{more}")


def shape_findings(shapes: int) -> Iterator[Finding]:
    """Relations that allow more than one shape."""
    if shapes > 1:
        yield Finding(
            "several_shapes",
            "warning",
            f"the known distances and angles allow {shapes} different shapes; this report is for the first one",
            "add a relation that only the real shape satisfies, or give every feature its place",
        )


def same_surface_findings(pairs: Sequence[tuple[str, str]]) -> Iterator[Finding]:
    """Features that are the same surface."""
    for one, other in pairs:
        yield Finding(
            "same_surface",
            "warning",
            f"{one} and {other} are the same surface: the second adds no independent contact",
            "check their places; if this is intended, one feature with a larger touch box is enough",
        )
