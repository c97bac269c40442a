"""Simulated contacts: from a fixture, a pose, noise and, on request, one mistake; with the truth.

1. The touches are those of a plan, or random ones (`touches`); the pose is given, or random (`poses`).
2. A mistake in the fixture file moves the touches to the real surfaces (`fixture_faults`).
3. The tip's centre is displaced from the surface by the tip's radius and by noise, and transformed to base.
4. The flange gets its orientations.
5. A mistake in the contacts changes them (`faults`).

All random numbers come from PCG64 streams, one each for pose, touches, noise, fault and
orientations, so that a fault does not change the others.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from tactfix.accessibility.access import access_of
from tactfix.accessibility.touchable import extent_of, sample_touches
from tactfix.contacts import Contacts
from tactfix.errors import UsageError
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats, Frozen
from tactfix.geometry.rigid import transform_points
from tactfix.geometry.surfaces import Point, Surface, standoff
from tactfix.probe import probe_settings, with_feature_sigmas
from tactfix.relations.realization import realize
from tactfix.results import JsonResult
from tactfix.simulation.faults import CONTACT_FAULTS, Fault, check_fault, growth, mistaken, scatter, touching_radius
from tactfix.simulation.fixture_faults import really
from tactfix.simulation.poses import drawn_pose, in_turn, tool_orientations
from tactfix.simulation.touches import planned_touches, random_touches
from tactfix.values import frozen_value


@frozen_value
class Simulation(JsonResult):
    """Simulated contacts in base, and the truth.

    Attributes
    ----------
    fixture, units : str
        Name of the fixture, and the unit of all lengths.
    contacts : Contacts
        In base.
    base_from_fixture : (4, 4) array
        The true pose, in units.
    seed : int
        Of the random numbers.
    planned : bool
        Whether the touches are those of a plan.
    fault : Fault or None
        The mistake that was made.
    mistake : str or None
        The mistake in words, with its size.

    Examples
    --------
    >>> made = tactfix.simulate(tactfix.load_fixture("fixtures/three-planes.yaml"), seed=1, count=9)
    >>> made.base_from_fixture.shape
    (4, 4)
    """

    fixture: str
    units: str
    contacts: Contacts
    base_from_fixture: Frozen
    seed: int
    planned: bool
    fault: Fault | None = None
    mistake: str | None = None

    def to_dict(self) -> dict[str, Any]:
        """The JSON of `tactfix simulate --json` as dictionaries, lists and numbers."""
        from tactfix.report.plan_report import simulation_json

        return simulation_json(self)

    def __repr__(self) -> str:
        fault = "no fault" if self.fault is None else f"fault {self.fault.kind}"
        return f"<Simulation {self.fixture!r}: {len(self.contacts)} contacts, seed {self.seed}, {fault}>"


def simulate(
    fixture: Fixture,
    plan: Contacts | None = None,
    base_from_fixture: Floats | None = None,
    sigma: float | None = None,
    tip_radius: float | None = None,
    seed: int = 0,
    count: int | None = None,
    fault: Fault | None = None,
    orientations: int | None = None,
) -> Simulation:
    """Simulate contacts on a fixture at a given or random pose.

    Parameters
    ----------
    fixture : Fixture
        To be touched.
    plan : Contacts, optional
        Nominal contacts in the fixture frame, as `plan` gives them; None: random touches inside the touch boxes,
        reachable in a straight line, with approaches in a cone about the normal. Contacts on points have no approach.
    base_from_fixture : (4, 4) array, optional
        The pose, in the fixture's units; None: a random pose that the fixture's placement allows, without a placement
        any pose, a metre or more away.
    sigma, tip_radius : float, optional
        In fixture units; None: those of the plan, or of the fixture's probe. A feature's own sigma is added to the
        noise in quadrature.
    seed : int
        Of pose, touches, noise and fault, each a stream of its own.
    count : int, optional
        Number of random touches.
    fault : Fault, optional
        A mistake to make.
    orientations : int, optional
        Number of tool orientations, used in turn, if the plan has no flange rotations. The tip's place in the flange is
        that of the fixture's probe, or else the flange's origin.

    Returns
    -------
    Simulation
        The contacts, in base, and the truth.

    Raises
    ------
    UsageError
        Less than one orientation, no sigma or tip_radius, a fixture whose relations do not place its features, a
        feature that cannot be reached, contacts that are no plan, or both plan and count.
    TipDoesNotFitError
        A tip that is not smaller than a bore.

    Notes
    -----
    x_i = R (p_i + (t + e_i) n_i) + translation, with p_i on the surface, n_i its outward normal, t the tip's radius and
    e_i normal noise; on a point, which determines the tip's centre, noise has all directions.

    Examples
    --------
    >>> cube = tactfix.load_fixture("fixtures/three-planes.yaml")
    >>> made = tactfix.simulate(cube, seed=1, count=9)
    >>> len(made.contacts), made.mistake is None
    (9, True)
    """
    check_fault(fault)
    if plan is not None and count is not None:
        raise UsageError("a plan determines the number of contacts; leave out the number of contacts")
    if orientations is not None and orientations < 1:
        raise UsageError(f"{orientations} tool orientations are not possible; ask for one or more")
    pose_stream, touch_stream, noise_stream, fault_stream = streams(seed, 4)
    surfaces = nominal_surfaces(fixture)
    probe_sigma, file_tip = probe_settings(fixture, plan, sigma, tip_radius)
    access = access_of(fixture, surfaces, touching_radius(fault, file_tip))
    # Step 1.
    touches = random_touches(access, count, touch_stream) if plan is None else planned_touches(access, plan)
    if base_from_fixture is None:
        base_from_fixture = drawn_pose(fixture, pose_stream)
    mistake = None
    if fault is not None:  # step 2
        touches, mistake = really(fault, surfaces, touches, probe_sigma, fault_stream)
    names, count = touches.features, len(touches.features)
    sigmas = np.full(count, probe_sigma) if sigma is not None or plan is None else plan.sigmas
    noises = scatter(fault) * with_feature_sigmas(sigmas, (fixture.features[name] for name in names))
    on_points = np.array([isinstance(surfaces[name], Point) for name in names])
    off = np.array([standoff(surfaces[name], access.tip_radius) for name in names])
    off = (off + noises * noise_stream.standard_normal(count))[:, None] * touches.normals  # step 3
    off[on_points] = noises[on_points, None] * noise_stream.standard_normal((int(on_points.sum()), 3))
    rotation = base_from_fixture[:3, :3]
    contacts = Contacts(
        features=names,
        points=transform_points(base_from_fixture, growth(fault) * touches.points + off),
        approaches=np.where(on_points[:, None], np.nan, touches.approaches @ rotation.T),
        sigmas=sigmas,
        tip_radius=file_tip,
        rows=tuple(range(1, count + 1)),
        ids=(None,) * count if plan is None else plan.ids,
        units=fixture.units,
    )
    contacts = _with_flange(contacts, fixture, plan, orientations, seed, rotation)  # step 4
    if fault is not None and fault.kind in CONTACT_FAULTS:  # step 5
        contacts, mistake = mistaken(fault, contacts, touches.normals @ rotation.T, fault_stream)
    return Simulation(
        fixture=fixture.name,
        units=fixture.units,
        contacts=contacts,
        base_from_fixture=base_from_fixture,
        seed=seed,
        planned=plan is not None,
        fault=fault,
        mistake=mistake,
    )


def _with_flange(
    contacts: Contacts, fixture: Fixture, plan: Contacts | None, count: int | None, seed: int, rotation: Floats
) -> Contacts:
    """The contacts with the flange rotations of the plan, or with count orientations in turn."""
    if plan is not None and plan.flange_rotations is not None:
        return replace(contacts, flange_rotations=rotation @ plan.flange_rotations, tip_offset=plan.tip_offset)
    if count is None:
        return contacts
    (stream,) = streams(seed, 5)[4:]
    rotations = tool_orientations(count, contacts.approaches, stream.uniform(0.0, 2 * np.pi))
    offset = np.array(fixture.probe.tip_offset or (0.0, 0.0, 0.0))
    return replace(contacts, flange_rotations=rotations[in_turn(contacts.features, count)], tip_offset=offset)


def streams(seed: int, count: int) -> list[np.random.Generator]:
    """Independent PCG64 generators, the same on every platform."""
    children = np.random.SeedSequence(seed).spawn(count)
    return [np.random.Generator(np.random.PCG64(child)) for child in children]


def nominal_surfaces(fixture: Fixture) -> Mapping[str, Surface]:
    """The features in the fixture frame, in the first shape of the fixture that meets all touch boxes.

    Raises UsageError if the file does not place them.
    """
    ways = realize(fixture)
    for surfaces in ways:
        centre, radius = extent_of(surfaces, fixture.touch)
        if all(len(sample_touches(surfaces[name], box, 1, centre, radius)[0]) for name, box in fixture.touch.items()):
            return surfaces
    if ways:
        # No shape meets all boxes: making the touches will name the feature.
        return ways[0]
    raise UsageError(
        f"{fixture.name}: the fixture file does not determine the relative places of all features; "
        "add the missing distances and angles, or each feature's place"
    )
