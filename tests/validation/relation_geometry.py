"""Twenty kinds of fixtures by relations, built by hand: places of features, relations in the file, frame recipe.

No code is shared with the package. Directions come from scipy's Rotation; the frame is computed from its recipe by
`frame_of`; files are written as text and read by the package like those of a user.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

X, Y, Z = np.eye(3)


@dataclass(frozen=True)
class Thing:
    """A feature in the part's own frame: point (at), normal or axis (along); half: half length of the touched piece."""

    kind: str
    at: np.ndarray
    along: np.ndarray = field(default_factory=lambda: Z)
    radius: float = 0.0
    side: str = "outer"
    half: float = 30.0


@dataclass(frozen=True)
class Part:
    """things by name; relations (kind, one, other, value, sigma) as stated in the file, deg; frame: recipe.

    touch: boxes in the fixture frame, if nothing else distinguishes two poses.
    """

    things: Mapping[str, Thing]
    relations: Sequence[tuple[str, str, str, float, float]]
    frame: Mapping[str, Mapping[str, object]]
    touch: Mapping[str, Mapping[str, Sequence[float]]] = field(default_factory=dict)


def leaning(degrees: float, azimuth: float = 0.0, aside: float = 0.0) -> np.ndarray:
    """The z direction inclined by an angle towards x, or another azimuth, and slightly sideways (deg)."""
    tilted = Rotation.from_euler("xyz", [aside, degrees, azimuth], degrees=True)
    return tilted.apply(Z)


def plane(at, along=Z, half=30.0):
    return Thing("plane", np.asarray(at, float), np.asarray(along, float), half=half)


def bar(at, along=Z, radius=8.0, side="outer", half=25.0):
    return Thing("cylinder", np.asarray(at, float), np.asarray(along, float), radius, side, half)


def ball(at, radius=10.0, side="outer"):
    return Thing("sphere", np.asarray(at, float), Z, radius, side)


@dataclass(frozen=True)
class Angle:
    """The angle of a part: value and sigma stated in the file (deg), and the true value of the part."""

    stated: float
    sigma: float
    true: float
    aside: float

    @staticmethod
    def drawn(stated: float, sigma: float, rng: np.random.Generator) -> "Angle":
        """A true angle that deviates by sigma; if axes are nearly parallel, in two directions."""
        off, aside = sigma * rng.standard_normal(2)
        return Angle(stated, sigma, stated + off, aside if min(stated, 180 - stated) < 1 else 0.0)

    def lean(self, azimuth: float = 0.0) -> np.ndarray:
        return leaning(self.true, azimuth, self.aside)

    def between(self, one: str, other: str) -> tuple[str, str, str, float, float]:
        return ("angle", one, other, self.stated, self.sigma)


def right(one, other, degrees=90.0):
    return ("angle", one, other, degrees, 0.0)


def apart(one, other, value):
    return ("distance", one, other, float(value), 0.0)


def with_axis(a: Angle) -> bool:
    return a.stated <= 90


def askew(a: Angle) -> bool:
    return 2 < a.stated <= 90


BALL = ball([15, 90, 50])


def bar_on_plate(a):
    """Plate and bar at an angle, a ball anywhere."""
    things = {"plate": plane([0, 0, 0]), "bar": bar([0, 0, 60], a.lean()), "ball": BALL}
    frame = {"origin": {"foot_of": "ball", "on": "bar"}, "z": {"along": "plate"}, "y": {"from": "bar", "to": "ball"}}
    return Part(things, [a.between("plate", "bar")], frame)


def bar_on_plate_ball_at_height(a):
    part = bar_on_plate(a)
    return Part(part.things, [*part.relations, apart("ball", "plate", 50.0)], part.frame)


def bar_beside_ball_on_plate(a):
    """Distance to the axis and height of the ball are given, its place along the bar is not."""
    part = bar_on_plate_ball_at_height(a)
    axis, arm = part.things["bar"].along, BALL.at - part.things["bar"].at
    return Part(part.things, [*part.relations, apart("bar", "ball", np.linalg.norm(np.cross(arm, axis)))], part.frame)


def crossed_bars(a):
    things = {"one": bar([0, 0, 0], Z), "two": bar([0, 70, 10], a.lean(), 6.0), "ball": ball([60, 25, 50])}
    frame = {"origin": {"center_of": "ball"}, "x": {"from": "one", "to": "ball"}, "y": {"from": "one", "to": "two"}}
    return Part(things, [a.between("one", "two")], frame)


def crossed_bars_apart(a):
    part = crossed_bars(a)
    normal = np.cross(part.things["one"].along, part.things["two"].along)
    value = abs(part.things["two"].at @ normal) / np.linalg.norm(normal)
    return Part(part.things, [*part.relations, apart("one", "two", value)], part.frame)


def two_bars_on_plate(a):
    things = {
        "plate": plane([0, 0, 0]),
        "one": bar([0, 0, 50], a.lean()),
        "two": bar([90, 20, 50], Z, 6.0),
        "ball": BALL,
    }
    frame = {"origin": {"meet_of": ["two", "plate"]}, "z": {"along": "plate"}, "x": {"from": "two", "to": "ball"}}
    return Part(things, [a.between("plate", "one"), right("plate", "two", 0.0)], frame)


def two_pins_pair_by_pair(a):
    part = two_bars_on_plate(a)
    return Part(part.things, [*part.relations, a.between("one", "two")], part.frame)


def pins_of_equal_lean(a):
    """Two parallel pins: the angle of one to the plate, their angle of 0 and their spacing are given."""
    things = {"plate": plane([0, 0, 0]), "one": bar([0, 0, 50], a.lean()), "two": bar([80, 10, 50], a.lean(), 6.0)}
    gap = things["two"].at - things["one"].at
    spacing = np.linalg.norm(np.cross(gap, a.lean()))
    relations = [a.between("plate", "one"), right("one", "two", 0.0), apart("one", "two", spacing)]
    frame = {"origin": {"meet_of": ["one", "plate"]}, "z": {"along": "plate"}, "x": {"from": "one", "to": "two"}}
    return Part(things, relations, frame)


def three_faces_and_ball(a):
    """Two faces at an angle, a third perpendicular to both."""
    things = {"a": plane([0, 0, 0]), "b": plane([60, 0, -40], a.lean()), "c": plane([0, -60, -40], -Y), "ball": BALL}
    frame = {"origin": {"center_of": "ball"}, "z": {"along": "a"}, "y": {"opposite": {"along": "c"}}}
    return Part(things, [a.between("a", "b"), right("a", "c")], frame)


def three_faces_at_all_angles(a):
    part = three_faces_and_ball(Angle(a.stated, a.sigma, a.true, 0.0))
    return Part(part.things, [*part.relations, right("b", "c")], part.frame)


def block(a):
    """Top and bottom at an angle, and two sides."""
    things = {
        "top": plane([0, 0, 0]),
        "bottom": plane([0, 0, -40], a.lean()),
        "left": plane([-50, 0, -20], -X, 15.0),
        "front": plane([0, -50, -20], -Y, 15.0),
    }
    frame = {
        "origin": {"meet_of": ["left", "front", "top"]},
        "z": {"along": "top"},
        "x": {"opposite": {"along": "left"}},
    }
    return Part(things, [a.between("top", "bottom")], frame)


def square_block(a):
    part = block(a)
    square = [right("top", "left"), right("top", "front"), right("left", "front")]
    return Part(part.things, [*part.relations, *square], part.frame)


def slab_with_hole(a):
    """An inclined hole through a slab of known thickness."""
    things = {
        "top": plane([0, 0, 0]),
        "bottom": plane([0, 0, -25], -Z),
        "hole": bar([0, 0, -12], a.lean(), 12.0, "inner", 10.0),
        "end": plane([-50, 0, -12], -X, 10.0),
    }
    relations = [
        right("top", "bottom", 180.0),
        apart("top", "bottom", 25.0),
        right("top", "end"),
        a.between("top", "hole"),
    ]
    frame = {"origin": {"meet_of": ["hole", "top"]}, "z": {"along": "top"}, "x": {"opposite": {"along": "end"}}}
    return Part(things, relations, frame)


def socket_and_bar(a):
    """An inner ball above a plate, at a known distance from an inclined bar."""
    things = {"plate": plane([0, 0, 0]), "bar": bar([0, 0, 60], a.lean()), "ball": ball([15, 90, 50], 12.0, "inner")}
    value = np.linalg.norm(np.cross(things["ball"].at - things["bar"].at, a.lean()))
    frame = {"origin": {"center_of": "ball"}, "z": {"along": "plate"}, "y": {"from": "bar", "to": "ball"}}
    return Part(things, [a.between("plate", "bar"), apart("bar", "ball", value)], frame)


def three_bars(a):
    """All distances and angles: the shape is determined, with many branches."""
    things = {
        "one": bar([0, 0, 0], Z),
        "two": bar([0, 70, 10], a.lean(), 6.0),
        "three": bar([60, 20, 20], Rotation.from_euler("xyz", [70, 20, 0], degrees=True).apply(Z), 7.0),
    }
    relations = []
    for one, other in (("one", "two"), ("one", "three"), ("two", "three")):
        u, v = things[one].along, things[other].along
        normal = np.cross(u, v)
        gap = abs((things[other].at - things[one].at) @ normal) / max(np.linalg.norm(normal), 1e-12)
        degrees = float(np.degrees(np.arccos(min(1.0, abs(u @ v)))))
        relations += [apart(one, other, gap)]
        relations += [a.between(one, other) if other == "two" else right(one, other, degrees)]
    frame = {
        "origin": {"foot_of": "three", "on": "one"},
        "x": {"from": "one", "to": "three"},
        "y": {"from": "one", "to": "two"},
    }
    return Part(things, relations, frame)


def three_bars_by_angles(a):
    part = three_bars(a)
    return Part(part.things, [r for r in part.relations if r[0] == "angle"], part.frame)


def bar_and_ball(_):
    """The paper's fixture: a half-turn about x maps it onto itself, and only the touch box of the bar decides."""
    things = {"bar": bar([0, 0, 35], Z), "ball": ball([40, 0, 0])}
    frame = {"origin": {"foot_of": "ball", "on": "bar"}, "z": {"along": "bar"}, "x": {"from": "bar", "to": "ball"}}
    return Part(things, [apart("bar", "ball", 40.0)], frame, {"bar": {"z": [5.0, 80.0]}})


def plate_and_two_balls(_):
    things = {"plate": plane([0, 0, 0]), "s1": ball([0, 0, 23], 8.0), "s2": ball([180, 60, 43], 14.0, "inner")}
    gap = float(np.linalg.norm(things["s2"].at - things["s1"].at))
    frame = {"origin": {"foot_of": "s1", "on": "plate"}, "z": {"along": "plate"}, "x": {"from": "s1", "to": "s2"}}
    return Part(things, [apart("s1", "s2", gap), apart("s1", "plate", 23.0), apart("plate", "s2", 43.0)], frame)


def balls(places):
    names = "abcd"[: len(places)]
    things = {n: ball(p) for n, p in zip(names, places, strict=True)}
    pairs = [(m, n) for m in names for n in names if m < n]
    relations = [apart(m, n, np.linalg.norm(things[m].at - things[n].at)) for m, n in pairs]
    frame = {"origin": {"center_of": "a"}, "x": {"from": "a", "to": "b"}, "y": {"from": "a", "to": "c"}}
    return Part(things, relations, frame)


def three_balls(_):
    return balls([[0, 0, 0], [150, 0, 0], [50, 120, 0]])


def four_balls(_):
    """Their mirror image has the same distances."""
    return balls([[0, 0, 0], [150, 0, 0], [50, 120, 0], [60, 50, 90]])


@dataclass(frozen=True)
class Kind:
    """make: the part for an angle; allows: which angles it can have, None if it has none.

    fixes_shape: whether the relations with this angle, if exact, leave only rigid motions of all features.
    """

    make: Callable[[Angle], Part]
    allows: Callable[[Angle], bool] | None
    fixes_shape: Callable[[float], bool]


def never(_: float) -> bool:
    return False


def always(_: float) -> bool:
    return True


def away_from_square(degrees: float) -> bool:
    """Axes at 89.9 deg are also at 90.1: contacts may not distinguish the shapes; a file by geometry has one."""
    return degrees < 89 or degrees == 90


def where_aligned(degrees: float) -> bool:
    """Only an axis along the normal has no direction of inclination."""
    return degrees == 0


KINDS = {
    f.__name__.replace("_", " "): Kind(f, allows, fixes_shape)
    for f, allows, fixes_shape in [
        (bar_on_plate, with_axis, never),
        (bar_on_plate_ball_at_height, with_axis, never),
        (bar_beside_ball_on_plate, with_axis, where_aligned),
        (crossed_bars, with_axis, never),
        (crossed_bars_apart, askew, never),
        (two_bars_on_plate, with_axis, never),
        (two_pins_pair_by_pair, with_axis, never),
        (pins_of_equal_lean, lambda a: a.stated < 60, where_aligned),
        (three_faces_and_ball, lambda a: True, never),
        (three_faces_at_all_angles, lambda a: True, never),
        (block, lambda a: True, never),
        (square_block, lambda a: True, never),
        (slab_with_hole, lambda a: a.stated < 60, never),
        (socket_and_bar, with_axis, never),
        (three_bars, askew, away_from_square),
        (three_bars_by_angles, with_axis, never),
        (bar_and_ball, None, always),
        (plate_and_two_balls, None, always),
        (three_balls, None, always),
        (four_balls, None, always),
    ]
}
