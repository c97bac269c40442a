"""Texts of fixture and contact files, and functions that write and read them."""

from pathlib import Path

PAPER = """tactfix: 1
name: paper
units: mm
features:
  bar: {type: cylinder, radius: 1.0}
  ball: {type: sphere, radius: 1.0}
distances:
  - {between: [bar, ball], value: 3.0}
frame:
  origin: {foot_of: ball, on: bar}
  y: {along: bar}
  x: {from: bar, to: ball}
touch:
  bar: {y: [0.2, 6.0]}
"""

PLACED = """tactfix: 1
units: mm
features:
  bar: {type: cylinder, radius: 8, point: [0, 0, 0], direction: [0, 3, 0]}
  ball: {type: sphere, radius: 10.0, center: [30, 0, 0], side: inner, sigma: 0.001}
  top: {type: plane, point: [0, 0, 15], normal: [0, 0, 2]}
"""

HEAD = "# units: mm\n# tip_radius: 0\n# sigma: 0.000002\n"
ROWS = [
    ("bar", 2.927025, 2.0, 1.625, -0.9, 0.0, 0.4),
    ("bar", 1.775, 2.8, 1.443785, 0.5, -0.5, 1.0),
    ("ball", 5.456074, 4.6, 2.543645, 0.0, -1.0, 0.0),
]


def contact_text(
    head: str = HEAD,
    separator: str = ",",
    decimal: str = ".",
    newline: str = "\n",
    names: str = "feature,x,y,z,ax,ay,az",
) -> str:
    """The contacts of ROWS in one of the accepted forms of contact files."""
    lines = [names.replace(",", separator)]
    lines += [separator.join([row[0], *(repr(v).replace(".", decimal) for v in row[1:])]) for row in ROWS]
    return (head + "\n".join(lines) + "\n").replace("\n", newline)


def written(folder: Path, text: str | bytes, name: str = "fixture.yaml") -> Path:
    """The path of a file with this content."""
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path
