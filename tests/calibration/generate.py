"""Write samples/robot-calibration, simulated with the arm of `support.arms`: `python -m tests.calibration.generate`."""

import numpy as np

from tests.support.arms import DH, PRIOR, SEATS, TIP, arm_cell, fixture, random_errors, touched_seats
from tests.support.project import ROOT

SAMPLE = ROOT / "samples" / "robot-calibration"


def main() -> None:
    rng = np.random.default_rng(19)
    cell = arm_cell(("all",), {name: fixture(dict(SEATS)) for name in ("front", "left", "high")})
    touches = touched_seats(cell, random_errors(cell, rng), 8, 0.05, rng)
    SAMPLE.mkdir(exist_ok=True)
    rows = "\n".join(f"      - {row.tolist()}" for row in DH)
    prior = {"joint_offset": np.rad2deg(PRIOR.joint_offset), "angle": np.rad2deg(PRIOR.angle)}
    text = f"""# a six-axis robot (simulated); its tip is held by three seats on a plate at three places
tactfix_cell: 1
units: mm
robot:
  dh:
    convention: standard
    rows: # a, d, alpha, theta
{rows}
probe: {{tip_radius: 5.0, sigma: 0.05, tip_offset: {TIP.tolist()}}}
unknown: all
prior: {{joint_offset: {prior["joint_offset"]:g}, length: {PRIOR.length}, angle: {prior["angle"]:g}, tip: {PRIOR.tip}}}
fixtures: {{plate: seats.yaml}}
places: {{front: plate, left: plate, high: plate}}
"""
    (SAMPLE / "cell.yaml").write_text(text, encoding="utf-8")
    seats = "\n".join(f"  {name}: {{type: point, point: {seat.point.tolist()}}}" for name, seat in SEATS.items())
    (SAMPLE / "seats.yaml").write_text(f"tactfix: 1\nname: seats\nunits: mm\nfeatures:\n{seats}\n", encoding="utf-8")
    lines = ["# joints: deg", "place,feature,q1,q2,q3,q4,q5,q6"]
    for place, feature, q in zip(touches.places, touches.features, np.rad2deg(touches.joints), strict=True):
        lines.append(",".join([place, feature, *(f"{angle:.6f}" for angle in q)]))
    (SAMPLE / "touches.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
