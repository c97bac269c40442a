"""The record of a locate as one HTML page that works offline: result, inputs and conventions."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import field
from datetime import datetime
from importlib.resources import files
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from tactfix.acceptance import shown_sigma
from tactfix.contacts import Contacts
from tactfix.errors import MissingExtraError
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.locate_result import LocateResult
from tactfix.report.html_scene import ELLIPSOID_SIGMAS, accused_rows, feature_colors, locate_figure, pose_colors
from tactfix.report.text_report import matrix_text, reason_text, residual_text, sentence, status_lines
from tactfix.values import frozen_value
from tactfix.version import VERSION
from tactfix.wording import borne

if TYPE_CHECKING:
    from jinja2 import Environment

POSE_CONVENTIONS: Final = (
    "base is the frame in which the probe reports contacts (robot base, machine or work frame); fixture is the frame "
    "of the fixture file.",
    "base_from_fixture takes fixture coordinates to base coordinates: x_base = R x_fixture + t, column vectors, both "
    "frames right-handed, det R = +1. The columns of R are the axes of the fixture in base, t is its origin.",
    "The approach of a contact is the direction in which the probe travelled, pointing into the material.",
    "With a tip radius above zero, contacts are centres of the tip, and touch surfaces offset by that radius; with a "
    "tip radius of zero they are points of the surface. No contact is moved along its approach.",
    "A residual is the distance of a contact from its surface (of a centre of the tip: from where the tip touches it) "
    "along the outward normal, positive out of the material.",
    "Sigma is one standard deviation. The covariance is of (d_rot, d_t) with R_true = exp([d_rot]) R and "
    "t_true = t + d_t: base axes, rotation about the fixture's origin, in rad and the fixture's unit.",
    "The ellipsoid contains the fixture's true origin in 95 of 100 cases, if sigma is right; it is drawn enlarged.",
    "All lengths on this page are in the fixture's unit.",
)


@frozen_value(eq=True)
class InputFile:
    """An input file: its role, name and content."""

    role: str
    name: str
    content: bytes

    @property
    def sha256(self) -> str:
        """The checksum that sha256sum prints."""
        return hashlib.sha256(self.content).hexdigest()

    @property
    def text(self) -> str:
        """The content for reading."""
        return self.content.decode("utf-8-sig", errors="replace")


@frozen_value(eq=True)
class Record:
    """The provenance of a page: the fixture, all inputs, the settings, and the time when it was made.

    notes: additional entries for the record (operator, machine), by name.
    """

    fixture: Fixture
    inputs: list[InputFile]
    settings: dict[str, str]
    made_at: datetime
    notes: dict[str, str] = field(default_factory=dict)


@frozen_value(eq=True)
class Provenance:
    """The provenance of a page about no single fixture; fields as in Record."""

    inputs: list[InputFile]
    settings: dict[str, str]
    made_at: datetime
    notes: dict[str, str] = field(default_factory=dict)


@frozen_value
class Judgement:
    """The acceptance limits of a located pose, and its other representations.

    written: the pose as a controller's text, by the name of the format. at: a point (3,) of the fixture frame.
    exceeded: messages about exceeded limits; gates: all limits set, by option.
    """

    written: dict[str, str] = field(default_factory=dict)
    at: Floats | None = None
    gates: dict[str, str] = field(default_factory=dict)
    exceeded: list[str] = field(default_factory=list)


def locate_page(record: Record, contacts: Contacts, result: LocateResult, judgement: Judgement | None = None) -> str:
    """The page of a locate. MissingExtraError without the extra."""
    judgement = judgement or Judgement()
    limits = 3.5 * float(np.max(contacts.sigmas))
    return render(
        "locate.html.j2",
        record,
        title=f"{result.fixture}: {result.status}",
        figure=locate_figure(record.fixture, contacts, result),
        result=result,
        colors=feature_colors(record.fixture),
        pose_colors=pose_colors(result),
        verdict=[sentence(result)] if result.status == "located" else list(status_lines(result)),
        matrix=None if result.base_from_fixture is None else matrix_text(result.base_from_fixture),
        axes=_ellipsoid_axes(result.covariance),
        sigmas=_sigmas(result.covariance, result.units),
        residual_scale=max([limits, *(abs(contact.residual) for contact in result.contacts)]),
        reason_text=reason_text,
        residual_text=residual_text,
        largest_residual=max((abs(contact.residual) for contact in result.contacts), default=0.0),
        judgement=judgement,
        sigma_at=None if judgement.at is None else shown_sigma(result, judgement.at),
        probe=_probe(contacts, result.units),
        accused=accused_rows(result),
        contact_sigma=float(np.min(contacts.sigmas)),
    )


def _probe(contacts: Contacts, units: str) -> dict[str, str]:
    """The sigma and tip radius that were used."""
    least, most = float(contacts.sigmas.min()), float(contacts.sigmas.max())
    sigma = f"{least:g}" if least == most else f"{least:g} to {most:g}"
    return {"sigma of a contact": f"{sigma} {units}", "tip radius": f"{contacts.tip_radius:g} {units}"}


def render(
    template: str,
    record: Record | Provenance,
    *,
    figure: Mapping[str, Any],
    conventions: Sequence[str] = POSE_CONVENTIONS,
    **context: Any,
) -> str:
    """A page from a template of this package, with the script of plotly; MissingExtraError without the extra."""
    environment, plotly_script = templates_and_plotly()
    return environment.get_template(template).render(
        figure=finite(figure),
        plotly_script=plotly_script,
        conventions=conventions,
        version=VERSION,
        inputs=record.inputs,
        settings=record.settings,
        notes=record.notes,
        made_at=record.made_at,
        **context,
    )


def templates_and_plotly() -> tuple["Environment", str]:
    """The templates next to this module, also where the package is a zip file, and plotly's script.

    Raises MissingExtraError without the extra.
    """
    try:
        from jinja2 import Environment, FunctionLoader, StrictUndefined
        from plotly.offline import get_plotlyjs  # type: ignore[import-untyped]
    except ImportError as error:
        raise MissingExtraError("report", "an HTML report") from error
    folder = files("tactfix.report") / "templates"
    loader = FunctionLoader(lambda name: (folder / name).read_text(encoding="utf-8"))
    environment = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["borne"] = borne
    return environment, get_plotlyjs()


def finite(figure: Mapping[str, Any]) -> Any:
    """The figure, through JSON once: ValueError for numbers that are not finite (bare NaN in the script)."""
    return json.loads(json.dumps(figure, allow_nan=False))


def _sigmas(covariance: Floats | None, units: str) -> dict[str, float]:
    """Sigma of each coordinate of the pose: degrees about, lengths along the base axes."""
    if covariance is None:
        return {}
    spread = np.sqrt(np.diag(covariance))
    turns = {f"turn about {axis} of base (deg)": float(np.rad2deg(spread[k])) for k, axis in enumerate("xyz")}
    return {**{f"origin along {axis} of base ({units})": float(spread[3 + k]) for k, axis in enumerate("xyz")}, **turns}


def _ellipsoid_axes(covariance: Floats | None) -> list[tuple[float, list[float]]]:
    """Half axes of the 95 per cent ellipsoid of the origin, the longest first, each with its direction in base."""
    if covariance is None:
        return []
    values, vectors = np.linalg.eigh(covariance[3:, 3:])
    lengths = ELLIPSOID_SIGMAS * np.sqrt(np.maximum(values, 0.0))
    return [(float(lengths[k]), vectors[:, k].tolist()) for k in (2, 1, 0)]
