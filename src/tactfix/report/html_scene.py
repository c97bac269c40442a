"""The fixture, its contacts and its uncertainty in 3D: traces and layout for plotly.js.

A figure is plain JSON, built here without plotly; only the page that shows it needs plotly's script.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Final, TypeAlias

import numpy as np

from tactfix.accessibility.touchable import extent_of
from tactfix.contacts import Contacts
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import inverse, transform_points
from tactfix.geometry.surfaces import Point, Surface, moved, outward_normals
from tactfix.locate_result import LocateResult
from tactfix.report.html_shapes import ellipsoid_grid, patch
from tactfix.results import Candidate, ContactResidual

Figure: TypeAlias = dict[str, Any]
Trace: TypeAlias = dict[str, Any]

# The palette of Okabe and Ito, which colour-blind people can distinguish.
_SURFACE_COLORS: Final = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#f0e442")
_AXIS_COLORS: Final = (("x", "#c0392b"), ("y", "#27ae60"), ("z", "#2980b9"))
_CANDIDATES_DRAWN: Final = 12
"""Number of candidates drawn."""
# Colours of the accepted poses, distinct from each other and from the features.
_POSE_COLORS: Final = ("#5e35b1", "#c62828", "#00695c", "#6d4c41")
_ACCUSED: Final = "#d50000"
ELLIPSOID_SIGMAS: Final = 2.7955
"""Radius, in sigma, of the ellipsoid that contains a three-dimensional normal variable with probability 0.95: the root
of the 0.95 quantile, 7.815, of chi-square with three degrees of freedom."""


def locate_figure(fixture: Fixture, contacts: Contacts, result: LocateResult) -> Figure:
    """The figure of a result of locate, in base: surfaces, contacts, approaches, frame, ellipsoid, other candidates.

    Each accepted pose of an ambiguous result has its own colour, except surfaces that all of them share.
    """
    colors = feature_colors(fixture)
    pose = result.base_from_fixture
    surfaces = result.surfaces or (result.candidates[0].surfaces if result.candidates else {})
    size = _size(contacts.points, surfaces)
    pose_color = pose_colors(result)
    drawn = result.surfaces if pose_color else surfaces
    traces = surface_traces(fixture, drawn, pose, colors, contacts)
    traces += _contact_traces(contacts, result.contacts, surfaces, colors, size)
    traces += _accused_traces(contacts, surfaces, accused_rows(result))
    traces += _next_contact_traces(result, 0.15 * size)
    if pose is not None:
        traces += frame_traces(pose, 0.3 * size, "fixture frame")
    if pose is not None and result.covariance is not None:
        traces.append(_ellipsoid_trace(pose, result.covariance, size, result.units))
    for number, candidate in enumerate(result.candidates[:_CANDIDATES_DRAWN], 1):
        if number in pose_color:
            traces += _pose_traces(fixture, candidate, number, pose_color[number], set(drawn), 0.2 * size)
        elif pose is None or not candidate.accepted:
            traces += _candidate_traces(fixture, candidate, number, 0.2 * size)
    return {"data": traces, "layout": layout(result.units, "base")}


def fixture_figure(fixture: Fixture, surfaces: Mapping[str, Surface]) -> Figure:
    """The figure of a fixture alone, in its own frame."""
    size = extent_of(surfaces, fixture.touch)[1] if surfaces else 1.0
    traces = surface_traces(fixture, surfaces, np.eye(4), feature_colors(fixture))
    return {
        "data": [*traces, *frame_traces(np.eye(4), 0.5 * size, "fixture frame")],
        "layout": layout(fixture.units, "fixture"),
    }


def feature_colors(fixture: Fixture) -> dict[str, str]:
    """A colour for each feature, in file order."""
    return {name: _SURFACE_COLORS[i % len(_SURFACE_COLORS)] for i, name in enumerate(fixture.features)}


def pose_colors(result: LocateResult) -> dict[int, str]:
    """A colour for each of the first accepted poses of an ambiguous result, by its number from 1."""
    if result.status != "ambiguous":
        return {}
    numbers = [number for number, candidate in enumerate(result.candidates, 1) if candidate.accepted]
    return dict(zip(numbers, _POSE_COLORS, strict=False))


def accused_rows(result: LocateResult) -> set[int]:
    """The rows of contacts that contradict the best pose, or that the most plausible diagnosis names."""
    rows = set(result.diagnosis[0].rows) if result.diagnosis else set()
    if result.status == "inconsistent":
        rows |= {reason.row for candidate in result.candidates[:1] for reason in candidate.reasons if reason.row}
    return rows


def layout(units: str, frame: str) -> dict[str, Any]:
    """Axes of equal scale, named with frame and unit; dragging turns freely."""
    axes = {f"{axis}axis": {"title": {"text": f"{axis} of {frame} ({units})"}} for axis in "xyz"}
    return {
        "scene": {"aspectmode": "data", "dragmode": "orbit", **axes},
        "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
        "legend": {"itemsizing": "constant", "y": 0.92},
        "uirevision": "kept",
    }


def surface_traces(
    fixture: Fixture,
    surfaces: Mapping[str, Surface],
    base_from_fixture: Floats | None,
    colors: Mapping[str, str],
    contacts: Contacts | None = None,
    **more: Any,
) -> list[Trace]:
    """Each surface to the ends of its touch box or of its contacts."""
    if not surfaces:
        return []
    pose = np.eye(4) if base_from_fixture is None else base_from_fixture
    boxes = {} if base_from_fixture is None else fixture.touch
    at_home = {name: moved(inverse(pose), surface) for name, surface in surfaces.items()}
    middle, radius = extent_of(at_home, boxes)
    traces = []
    for name, surface in at_home.items():
        points = np.zeros((0, 3)) if contacts is None else contacts.on(name).points
        grid = patch(surface, boxes.get(name), middle, radius, transform_points(inverse(pose), points))
        if grid is not None:
            traces.append(_grid_trace(name, colors[name], transform_points(pose, grid), **more))
    return traces


def frame_traces(base_from_fixture: Floats, length: float, name: str, **more: Any) -> list[Trace]:
    """Three arrows without heads, named at their ends; one entry of the legend for all."""
    origin, rotation = base_from_fixture[:3, 3], base_from_fixture[:3, :3]
    return [
        {
            **_line([origin, origin + length * rotation[:, k]], color, 6),
            **{"mode": "lines+text", "text": ["", axis], "name": name, "legendgroup": name, "showlegend": k == 0},
            **more,
        }
        for k, (axis, color) in enumerate(_AXIS_COLORS)
    ]


def magnification(covariance: Floats, size: float) -> float:
    """A round factor by which the 95 per cent ellipsoid of the origin must grow to be seen in a scene of that size."""
    largest = ELLIPSOID_SIGMAS * float(np.sqrt(np.linalg.eigvalsh(covariance[3:, 3:])[-1]))
    return float(10.0 ** np.floor(np.log10(0.15 * size / largest))) if largest > 0 else 1.0


def _size(points: Floats, surfaces: Mapping[str, Surface]) -> float:
    """Half the diagonal of the box around contacts and centres."""
    places = [points, *(np.atleast_2d(getattr(s, "center", points[0])) for s in surfaces.values())]
    spread = np.ptp(np.concatenate(places), axis=0)
    return float(np.linalg.norm(spread)) / 2 or 1.0


def _grid_trace(name: str, color: str, grid: Floats, **more: Any) -> Trace:
    x, y, z = np.moveaxis(grid, -1, 0).tolist()
    flat = {"colorscale": [[0, color], [1, color]], "showscale": False, "opacity": 0.45, "hoverinfo": "name"}
    return {"type": "surface", "name": name, "showlegend": True, "x": x, "y": y, "z": z, **flat, **more}


def _line(points: Sequence[Floats | None], color: str, width: float) -> Trace:
    """A line through points; None lifts the pen."""
    rows = [[None] * 3 if point is None else np.asarray(point).tolist() for point in points]
    x, y, z = zip(*rows, strict=True) if rows else ((), (), ())
    pen = {"color": color, "width": width}
    return {"type": "scatter3d", "mode": "lines", "x": x, "y": y, "z": z, "line": pen, "hoverinfo": "skip"}


def _contact_traces(
    contacts: Contacts,
    residuals: Sequence[ContactResidual],
    surfaces: Mapping[str, Surface],
    colors: Mapping[str, str],
    size: float,
) -> list[Trace]:
    """The contacts of each feature as points, and lines along which the probe came."""
    by_row = {residual.row: residual for residual in residuals}
    traces: list[Trace] = []
    for name in contacts.by_feature:
        on = contacts.on(name)
        touched = _touched(on, surfaces.get(name))
        x, y, z = touched.T.tolist()
        text = [_hover(on, i, by_row.get(row)) for i, row in enumerate(on.rows)]
        marker = {"size": 5, "color": colors[name], "line": {"color": "#222", "width": 1}}
        legend = {"name": f"contacts on {name}", "legendgroup": f"contacts {name}"}
        points = {"type": "scatter3d", "mode": "markers", "x": x, "y": y, "z": z, "marker": marker, "text": text}
        traces.append({**points, **legend, "hoverinfo": "text"})
        ways: list[Floats | None] = []
        for point, approach in zip(touched, on.approaches, strict=True):
            if np.isfinite(approach).all():
                ways += [point - 0.15 * size * approach, point, None]
        if ways:
            traces.append({**_line(ways, "#808080", 3), **legend, "showlegend": False})
    return traces


def _hover(contacts: Contacts, index: int, residual: ContactResidual | None) -> str:
    """The hover text of a contact; plotly interprets HTML tags, so < and > in names are replaced."""
    name = contacts.features[index].replace("<", "(").replace(">", ")")
    label = contacts.label(index).replace("<", "(").replace(">", ")")
    lines = [f"{name}, {label}"]
    if residual is not None:
        lines.append(f"residual {residual.residual:+.3g}")
        if residual.approach_angle_deg is not None:
            lines.append(f"approach {residual.approach_angle_deg:.0f} degrees off the normal")
    return "<br>".join(lines)


def _touched(contacts: Contacts, surface: Surface | None) -> Floats:
    """Where the tip touched (n, 3): contacts on one feature are drawn on its surface."""
    if surface is None or contacts.tip_radius == 0 or isinstance(surface, Point):
        return contacts.points
    return contacts.points - contacts.tip_radius * outward_normals(surface, contacts.points)


def _accused_traces(contacts: Contacts, surfaces: Mapping[str, Surface], rows: set[int]) -> list[Trace]:
    """A red ring around each suspected contact."""
    index = [i for i, row in enumerate(contacts.rows) if row in rows]
    if not index:
        return []
    each = [_touched(contacts.subset([i]), surfaces.get(contacts.features[i])) for i in index]
    x, y, z = np.concatenate(each).T.tolist()
    name = f"suspect: row {', '.join(str(contacts.rows[i]) for i in index[:4])}" + (" ..." if len(index) > 4 else "")
    marker = {"size": 12, "symbol": "circle-open", "color": _ACCUSED, "line": {"color": _ACCUSED, "width": 3}}
    points = {"type": "scatter3d", "mode": "markers", "x": x, "y": y, "z": z, "marker": marker}
    return [{**points, "name": name, "hoverinfo": "name"}]


def _next_contact_traces(result: LocateResult, length: float) -> list[Trace]:
    """The next contact and its approach; empty if its point in base is unknown."""
    contact = result.next_contact
    if contact is None or contact.point is None:
        return []
    x, y, z = ([float(value)] for value in contact.point)
    legend = {"name": f"next contact, on {contact.feature}", "legendgroup": "next contact"}
    marker = {"size": 7, "symbol": "diamond", "color": "#ff4081", "line": {"color": "#222", "width": 1}}
    point = {"type": "scatter3d", "mode": "markers", "x": x, "y": y, "z": z, "marker": marker, "hoverinfo": "name"}
    if contact.approach is None:  # on a point
        return [{**point, **legend}]
    way = _line([contact.point - length * contact.approach, contact.point], "#ff4081", 5)
    return [{**point, **legend}, {**way, **legend, "showlegend": False}]


def _pose_traces(
    fixture: Fixture, candidate: Candidate, number: int, color: str, shared: set[str], size: float
) -> list[Trace]:
    """An accepted pose: its frame, and its surfaces except those that all poses share."""
    name = f"pose {number}"
    group: dict[str, Any] = {"legendgroup": name}
    pose = candidate.base_from_fixture
    shapes = surface_traces(fixture, candidate.surfaces, pose, dict.fromkeys(fixture.features, color), **group)
    shapes = [{**shape, "showlegend": False} for shape in shapes if shape["name"] not in shared]
    ends = ("x", "y", f"z of {name}")
    axes = [
        {**_line([pose[:3, 3], pose[:3, 3] + size * pose[:3, k]], color, 6), **group, "name": name}
        | {"mode": "lines+text", "text": ["", end], "showlegend": k == 0}
        for k, end in enumerate(ends)
    ]
    return [*axes, *shapes]


def _ellipsoid_trace(pose: Floats, covariance: Floats, size: float, units: str) -> Trace:
    factor = magnification(covariance, size)
    values, axes = np.linalg.eigh(covariance[3:, 3:])
    half_axes = factor * ELLIPSOID_SIGMAS * np.sqrt(np.maximum(values, 0.0))
    grid = pose[:3, 3] + ellipsoid_grid(half_axes, axes)
    return _grid_trace(f"95 %, {factor:g} times larger", "#7f3fbf", grid)


def _candidate_traces(fixture: Fixture, candidate: Candidate, number: int, size: float) -> list[Trace]:
    """Another candidate: its frame, and its surfaces once its entry in the legend is clicked."""
    name = f"pose {number}" + ("" if candidate.accepted else " (rejected)")
    hidden: dict[str, Any] = {"visible": "legendonly", "legendgroup": name, "opacity": 0.25}
    grey = dict.fromkeys(fixture.features, "#888888")
    shapes = surface_traces(fixture, candidate.surfaces, candidate.base_from_fixture, grey, **hidden, showlegend=False)
    return [*frame_traces(candidate.base_from_fixture, size, name, visible="legendonly"), *shapes]
