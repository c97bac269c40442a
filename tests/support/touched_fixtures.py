"""Six fixtures, touched at a known pose."""

import numpy as np

from tests.support.problems import BALLS, CORNER, CYLINDER_SPHERE, PLATE, Patch, touch_all

BUSH = {
    "face": Patch("plane", (100, 0, 0), (0, 0, 1), length=25.0),
    "bush": Patch("cylinder", (0, 0, 0), (0, 0, 1), 15.0, side="inner", length=10.0, middle=-14.0),
    "ball": Patch("sphere", (200, 0, 45), radius=12.7, up=0.0),
}
CASES = {
    "plate": (PLATE, {"plate": 4, "pin": 5, "ball": 4}),
    "corner": (CORNER, {"right": 3, "back": 3, "top": 3}),
    "balls": (BALLS, {"a": 4, "b": 4, "c": 4}),
    "bar": (CYLINDER_SPHERE, {"bar": 7, "ball": 4}),
    "bush": (BUSH, {"face": 4, "bush": 5, "ball": 4}),
    "minimal": (CORNER, {"right": 3, "back": 2, "top": 1}),
}


def problem(name, seed=0, sigma=0.02, tip=1.5):
    patches, counts = CASES[name]
    if name == "bar":
        sigma, tip = 1e-3, 0.0
    rng = np.random.default_rng(seed)
    truth = touch_all(patches, counts, rng, sigma=sigma, tip=tip)
    return {n: p.surface() for n, p in patches.items()}, truth, truth.contacts(rng)
