"""The frame recipe: features that exist, of types that the rules can use, and two axes that are not the same."""

from collections.abc import Iterator
from typing import Final

from tactfix.models.declared import Declared
from tactfix.models.document import FixtureDocument
from tactfix.models.feature_sense import given_places, is_placed
from tactfix.models.findings import Finding, Path
from tactfix.models.frame import Along, CenterOf, FootOf, FrameModel, FromTo, MeetOf, Opposite

_FEET: Final = {("sphere", "cylinder"), ("sphere", "plane"), ("cylinder", "cylinder")}
_MEETINGS: Final = {("plane", "plane", "plane"), ("cylinder", "plane")}


def check_frame(document: FixtureDocument, declared: Declared) -> Iterator[Finding]:
    """Findings about the frame, and that it is missing where it is needed."""
    if document.frame is None:
        if not declared.frame_refused and not is_placed(document) and not _any_placed(document):
            remedy = "add frame: {origin: ..., and two of x, y, z}, or give every feature its place"
            yield Finding((), "there is no frame, and the features do not carry their place", remedy)
        return
    yield from _check_origin(document.frame, declared)
    axes = document.frame.axes
    if len(axes) != 2:
        what = f"frame has {len(axes)} of the axes x, y, z"
        yield Finding(("frame",), what, "give two of them; the third follows", at_key=True)
    for axis, model in axes:
        yield from _check_axis(("frame", axis), model, declared)
        yield from _check_length(("frame", axis), model, document)
    if len(axes) == 2 and _names(axes[0][1]) == _names(axes[1][1]):
        what = f"{axes[0][0]} and {axes[1][0]} follow the same line"
        yield Finding(("frame", axes[1][0]), what, "take another feature for one of them")


def _any_placed(document: FixtureDocument) -> bool:
    """Whether places have been begun: then what misses is told there."""
    return any(given_places(feature) for feature in document.features.values())


def _check_origin(frame: FrameModel, declared: Declared) -> Iterator[Finding]:
    match frame.origin:
        case CenterOf(center_of=name):
            path: Path = ("frame", "origin", "center_of")
            yield from declared.unknown(name, path)
            if declared.type_of(name) not in (None, "sphere"):
                what = f"{name} is a {declared.type_of(name)} and has no centre"
                yield Finding(path, what, "name a sphere, or use foot_of or meet_of")
        case FootOf(foot_of=above, on=below):
            yield from _check_foot(above, below, declared)
        case MeetOf(meet_of=names):
            yield from _check_meeting(names, declared)


def _check_foot(above: str, below: str, declared: Declared) -> Iterator[Finding]:
    yield from declared.unknown(above, ("frame", "origin", "foot_of"))
    yield from declared.unknown(below, ("frame", "origin", "on"))
    types = (declared.type_of(above), declared.type_of(below))
    if above == below:
        what = f"{above} has no foot on itself"
        yield Finding(("frame", "origin", "on"), what, "name the cylinder or plane that the foot is on")
    elif None not in types and types not in _FEET:
        what = f"{above}, a {types[0]}, has no foot on {below}, a {types[1]}"
        remedy = "take a sphere above a cylinder or plane, or two cylinders"
        yield Finding(("frame", "origin"), what, remedy)


def _check_meeting(names: list[str], declared: Declared) -> Iterator[Finding]:
    for index, name in enumerate(names):
        yield from declared.unknown(name, ("frame", "origin", "meet_of", index))
    types = [declared.type_of(name) for name in names]
    if len(set(names)) < len(names):
        yield Finding(("frame", "origin", "meet_of"), "a feature stands here twice", "name different features")
    elif None not in types and tuple(sorted(str(type_) for type_ in types)) not in _MEETINGS:
        what = f"a {', a '.join(map(str, types))} do not meet in a point"
        yield Finding(("frame", "origin", "meet_of"), what, "name three planes, or a cylinder and a plane")


def _check_axis(path: Path, model: Along | FromTo | Opposite, declared: Declared) -> Iterator[Finding]:
    if isinstance(model, Opposite):
        yield from _check_axis((*path, "opposite"), model.opposite, declared)
    elif isinstance(model, Along):
        yield from declared.unknown(model.along, (*path, "along"))
        if declared.type_of(model.along) == "sphere":
            what = f"{model.along} is a sphere and has no direction"
            yield Finding((*path, "along"), what, "name a cylinder or plane, or use from and to")
    else:
        yield from _check_from_to(path, model, declared)


def _check_from_to(path: Path, model: FromTo, declared: Declared) -> Iterator[Finding]:
    yield from declared.unknown(model.from_, (*path, "from"))
    yield from declared.unknown(model.to, (*path, "to"))
    types = {declared.type_of(model.from_), declared.type_of(model.to)}
    if model.from_ == model.to:
        yield Finding((*path, "to"), f"{model.to} is where the axis comes from", "name another feature")
    elif None not in types and "plane" in types and "sphere" not in types:
        what = f"there is no one direction from {model.from_} to {model.to}"
        yield Finding(path, what, "use along for the normal of a plane; from and to take spheres and cylinders")


def _check_length(path: Path, model: Along | FromTo | Opposite, document: FixtureDocument) -> Iterator[Finding]:
    """A direction from one feature to another needs a distance between them."""
    direction = model.opposite if isinstance(model, Opposite) else model
    if isinstance(direction, FromTo) and any(
        set(distance.between) == {direction.from_, direction.to} and distance.value == 0
        for distance in document.distances
    ):
        what = f"there is no direction from {direction.from_} to {direction.to}: their distance is 0"
        yield Finding(path, what, "take another feature for this axis")


def _names(model: Along | FromTo | Opposite) -> frozenset[str]:
    """The features that an axis follows, whichever way it points."""
    match model:
        case Opposite(opposite=direction):
            return _names(direction)
        case Along(along=name):
            return frozenset((name,))
        case FromTo(from_=start, to=end):
            return frozenset((start, end))
    raise TypeError(model)
