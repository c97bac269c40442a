"""Plans and simulations as JSON, in the fixture's units."""

from typing import Final

from tactfix.contacts import Contacts
from tactfix.planning.result import Plan
from tactfix.report.json_report import Json, array, number
from tactfix.simulation.simulate import Simulation
from tactfix.version import VERSION

PLAN_SCHEMA: Final = "tactfix/plan/1"
SIMULATE_SCHEMA: Final = "tactfix/simulate/1"


def plan_json(plan: Plan) -> Json:
    """The JSON of plan: contacts in the frame that "frame" names, and in base where "transform" is known."""
    return {
        "schema": PLAN_SCHEMA,
        "tactfix_version": VERSION,
        "fixture": plan.fixture,
        "units": plan.units,
        "frame": plan.frame,
        "transform": array(plan.base_from_fixture),
        "criterion": plan.criterion,
        "unique": plan.unique,
        "located": plan.located,
        "rivals": plan.rivals,
        "starts": plan.starts,
        "agreeing": plan.agreeing,
        "worst_sigma": number(plan.worst_sigma),
        "worst_point": array(plan.worst_point),
        "covariance": array(plan.covariance),
        "tip_radius": number(plan.contacts.tip_radius),
        "tip_sigma": number(plan.tip_sigma),
        "contacts": _planned(plan),
        "steps": [
            {
                "contacts": step.count,
                "worst_sigma": number(step.worst_sigma),
                "gain": number(step.gain),
                "unique": step.unique,
            }
            for step in plan.steps
        ],
    }


def simulation_json(simulation: Simulation) -> Json:
    """The JSON of simulate: contacts in base, and the truth."""
    return {
        "schema": SIMULATE_SCHEMA,
        "tactfix_version": VERSION,
        "fixture": simulation.fixture,
        "units": simulation.units,
        "transform": array(simulation.base_from_fixture),
        "seed": simulation.seed,
        "fault": None if simulation.fault is None else simulation.fault.kind,
        "mistake": simulation.mistake,
        "tip_radius": number(simulation.contacts.tip_radius),
        "contacts": _contacts(simulation.contacts),
    }


def _planned(plan: Plan) -> list[Json]:
    """The contacts of a plan, with their place in base, null where that is not known."""
    in_base = plan.in_base
    return [
        {
            **contact,
            "point_in_base": None if in_base is None else array(in_base.points[i]),
            "approach_in_base": None if in_base is None else array(in_base.approaches[i]),
            "flange_in_fixture": _flange(plan, i),
        }
        for i, contact in enumerate(_contacts(plan.contacts))
    ]


def _flange(plan: Plan, i: int) -> object:
    """How the flange stands in the fixture frame (3, 3), null where no orientations were planned."""
    rotations = plan.contacts.flange_rotations
    if rotations is None:
        return None
    stands = plan.base_from_fixture
    return array(rotations[i] if plan.frame == "fixture" or stands is None else stands[:3, :3].T @ rotations[i])


def _contacts(contacts: Contacts) -> list[Json]:
    return [
        {
            "row": contacts.rows[i],
            "feature": contacts.features[i],
            "point": array(contacts.points[i]),
            "approach": array(contacts.approaches[i]) if contacts.has_approach[i] else None,
            "sigma": number(contacts.sigmas[i]),
        }
        for i in range(len(contacts))
    ]
