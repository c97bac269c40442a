"""The table of all mistakes that simulation makes, diagnosis identifies and design_check assesses.

If one of the three does not cover a mistake, `but` gives the reason.
"""

from typing import Final, Literal, TypeAlias

from tactfix.values import frozen_value

FaultKind: TypeAlias = Literal[
    "outlier",
    "outliers",
    "reversed-approach",
    "reversed-approaches",
    "swapped-labels",
    "wrong-label",
    "exchanged-features",
    "wrong-unit",
    "forgotten-tip",
    "tip-sign",
    "late-trigger",
    "thermal-growth",
    "wrong-sigma",
    "wrong-tip",
    "wrong-radius",
    "diameters",
    "wrong-side",
    "wrong-place",
    "exchanged-axes",
    "mirrored",
]
DiagnosisCode: TypeAlias = Literal[
    "outlier",
    "approach",
    "swapped_labels",
    "relabel",
    "feature_exchange",
    "unit",
    "tip_radius",
    "tip_offset",
    "sigma",
    "radius",
    "diameter",
    "side",
    "feature_place",
    "axes",
    "mirrored",
]
BlindSpotCode: TypeAlias = Literal[
    "tip_radius",
    "tip_sign",
    "tip_offset",
    "pretravel",
    "scale",
    "unit",
    "sigma",
    "approach",
    "one_approach",
    "labels",
    "swapped_contacts",
    "wrong_label",
    "contact",
    "contacts",
    "distance",
    "radius",
    "diameter",
    "side",
    "axes",
    "mirrored",
]


@frozen_value(eq=True)
class Mistake:
    """One mistake in words; fault, cause, blind_spot: its codes in simulate, diagnosis and design_check.

    A code is None if the tool does not cover the mistake; but: the reason. needs: what the mistake requires.
    """

    words: str
    fault: FaultKind | None
    cause: DiagnosisCode | None
    blind_spot: BlindSpotCode | None
    needs: str = ""
    but: str = ""


MISTAKES: Final = (
    Mistake("the tip radius is forgotten", "forgotten-tip", "tip_radius", "tip_radius", "a tip"),
    Mistake("the tip radius is taken off on the wrong side", "tip-sign", "tip_radius", "tip_sign", "a tip"),
    Mistake(
        "the tip is not where the file says in the flange frame",
        "wrong-tip",
        "tip_offset",
        "tip_offset",
        "flange orientations that differ",
    ),
    Mistake("the probe triggers late", "late-trigger", "tip_radius", "pretravel"),
    Mistake(
        "the fixture is warmer than when it was measured",
        "thermal-growth",
        None,
        "scale",
        but="growth by a few kelvin is seldom detectable, and is then found as sigma, place or radius",
    ),
    Mistake("the coordinates are in another unit", "wrong-unit", "unit", "unit"),
    Mistake("contacts are noisier than sigma says", "wrong-sigma", "sigma", "sigma", "eight contacts"),
    Mistake("all approaches are reversed", "reversed-approaches", "approach", "approach", "approaches"),
    Mistake("one approach is reversed", "reversed-approach", "approach", "one_approach", "approaches"),
    Mistake("features are taken for each other", "exchanged-features", "feature_exchange", "labels", "two features"),
    Mistake("two labels are swapped", "swapped-labels", "swapped_labels", "swapped_contacts", "two features"),
    Mistake("one contact is on another feature", "wrong-label", "relabel", "wrong_label", "two features"),
    Mistake("one contact is off its surface", "outlier", "outlier", "contact"),
    Mistake("two or three contacts are off", "outliers", "outlier", "contacts", "nine contacts"),
    Mistake("one radius is another one", "wrong-radius", "radius", "radius", "a sphere or cylinder"),
    Mistake("radii are diameters", "diameters", "diameter", "diameter", "a sphere or cylinder"),
    Mistake("a pin is written as a bore, or a bore as a pin", "wrong-side", "side", "side", "a sphere or cylinder"),
    Mistake("one feature is not where the file says", "wrong-place", "feature_place", "distance", "two features"),
    Mistake("two coordinates of a feature are exchanged", "exchanged-axes", "axes", "axes", "a feature that it moves"),
    Mistake("the fixture is mirrored", "mirrored", "mirrored", "mirrored"),
)  # fmt: skip
FAULT_KINDS: Final = tuple(dict.fromkeys(one.fault for one in MISTAKES if one.fault))
CAUSES: Final = tuple(dict.fromkeys(one.cause for one in MISTAKES if one.cause))
BLIND_SPOTS: Final = tuple(dict.fromkeys(one.blind_spot for one in MISTAKES if one.blind_spot))
