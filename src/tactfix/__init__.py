"""tactfix: where a fixture stands, from a handful of touches.

    fixture = tactfix.load_fixture("fixtures/cylinder-sphere.yaml")
    contacts = tactfix.load_contacts("samples/cylinder-sphere/contacts.csv", fixture)
    result = tactfix.locate(fixture, contacts)
    if result.status == "located":
        print(result.pose.base_from_fixture)

In:          load_fixture, Fixture.from_features, load_contacts, contacts_from_arrays, load_pose, ContactOptions
Where:       locate, batch, check, compare, guide; fit for one surface alone
Beforehand:  design_check, plan, simulate, qualify
Robot:       load_cell, load_touches, calibrate, write_robot
Out:         write_pose, html_report; to_json and to_dict of results, from_json of locate, fit and qualify
Stacks:      cylinders_through_five, sphere_centers: many minimal problems at once
Errors:      all are TactfixError; FileError has every problem of a file

`help(tactfix.locate)` tells one of them; tactfix.parts has the types of what results hold. Lengths are in the unit of
the fixture, angles in rad, poses are base_from_fixture. Each name is imported when it is first asked for, so that
`import tactfix` costs next to nothing.
"""

from tactfix.version import VERSION

# Not imported from typing, which takes longer than all else that happens before the command line can tell a Ctrl-C.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from tactfix.batching.row import BatchRow
    from tactfix.calibration.cell import Touches
    from tactfix.calibration.result import Calibration
    from tactfix.contact_arrays import contacts_from_arrays
    from tactfix.contacts import Contacts
    from tactfix.design.design_check import design_check
    from tactfix.design.design_report import DesignReport, Wishes
    from tactfix.errors import (
        DegenerateContactsError,
        FileError,
        MissingExtraError,
        NotLocatedError,
        NotQualifiedError,
        OtherFixtureError,
        PoseRefusedError,
        Problem,
        TactfixError,
        TipDoesNotFitError,
        UsageError,
    )
    from tactfix.feature import Feature
    from tactfix.files.cell_file import CellFile, load_cell
    from tactfix.files.contact_options import ContactOptions
    from tactfix.files.contact_source import load_contacts
    from tactfix.files.fixture_file import load_fixture
    from tactfix.files.pose_file import load_pose
    from tactfix.files.robot_file import write_robot
    from tactfix.fitting.fit import fit
    from tactfix.fitting.result import FitResult
    from tactfix.fixture import Fixture, Probe
    from tactfix.localization.locate import locate
    from tactfix.locate_result import LocatedResult, LocateResult, NotLocatedResult
    from tactfix.monitoring.check import CheckResult, check
    from tactfix.monitoring.drift import CheckRecord
    from tactfix.monitoring.guide import GuideStep, guide
    from tactfix.placement import Placement
    from tactfix.planning.plan import plan
    from tactfix.planning.result import Plan
    from tactfix.pose_formats.comparison import Limits, Movement, compare
    from tactfix.pose_formats.convert import write_pose
    from tactfix.pose_formats.pose import Pose
    from tactfix.qualification.qualify import qualify
    from tactfix.qualification.result import QualifyResult
    from tactfix.records import batch, calibrate, html_report, load_touches
    from tactfix.simulation.faults import Fault
    from tactfix.simulation.simulate import Simulation, simulate
    from tactfix.stacks.five_contact_cylinders import CylinderStack, cylinders_through_five
    from tactfix.stacks.sphere_centers import SphereCenters, sphere_centers

__version__ = VERSION

__all__ = [
    "BatchRow",
    "Calibration",
    "CellFile",
    "CheckRecord",
    "CheckResult",
    "ContactOptions",
    "Contacts",
    "CylinderStack",
    "DegenerateContactsError",
    "DesignReport",
    "Fault",
    "Feature",
    "FileError",
    "FitResult",
    "Fixture",
    "GuideStep",
    "Limits",
    "LocateResult",
    "LocatedResult",
    "MissingExtraError",
    "Movement",
    "NotLocatedError",
    "NotLocatedResult",
    "NotQualifiedError",
    "OtherFixtureError",
    "Placement",
    "Plan",
    "Pose",
    "PoseRefusedError",
    "Probe",
    "Problem",
    "QualifyResult",
    "Simulation",
    "SphereCenters",
    "TactfixError",
    "TipDoesNotFitError",
    "Touches",
    "UsageError",
    "Wishes",
    "__version__",
    "batch",
    "calibrate",
    "check",
    "compare",
    "contacts_from_arrays",
    "cylinders_through_five",
    "design_check",
    "fit",
    "guide",
    "html_report",
    "load_cell",
    "load_contacts",
    "load_fixture",
    "load_pose",
    "load_touches",
    "locate",
    "plan",
    "qualify",
    "simulate",
    "sphere_centers",
    "write_pose",
    "write_robot",
]

_HOMES = {
    "BatchRow": "tactfix.batching.row",
    "Calibration": "tactfix.calibration.result",
    "CellFile": "tactfix.files.cell_file",
    "Touches": "tactfix.calibration.cell",
    "calibrate": "tactfix.records",
    "load_cell": "tactfix.files.cell_file",
    "load_touches": "tactfix.records",
    "write_robot": "tactfix.files.robot_file",
    "CheckRecord": "tactfix.monitoring.drift",
    "CheckResult": "tactfix.monitoring.check",
    "ContactOptions": "tactfix.files.contact_options",
    "Contacts": "tactfix.contacts",
    "CylinderStack": "tactfix.stacks.five_contact_cylinders",
    "DesignReport": "tactfix.design.design_report",
    "Fault": "tactfix.simulation.faults",
    "FileError": "tactfix.errors",
    "FitResult": "tactfix.fitting.result",
    "Feature": "tactfix.feature",
    "Placement": "tactfix.placement",
    "Probe": "tactfix.fixture",
    "Fixture": "tactfix.fixture",
    "GuideStep": "tactfix.monitoring.guide",
    "Limits": "tactfix.pose_formats.comparison",
    "LocateResult": "tactfix.locate_result",
    "LocatedResult": "tactfix.locate_result",
    "NotLocatedResult": "tactfix.locate_result",
    "Movement": "tactfix.pose_formats.comparison",
    "Plan": "tactfix.planning.result",
    "Pose": "tactfix.pose_formats.pose",
    "Problem": "tactfix.errors",
    "QualifyResult": "tactfix.qualification.result",
    "Simulation": "tactfix.simulation.simulate",
    "SphereCenters": "tactfix.stacks.sphere_centers",
    "DegenerateContactsError": "tactfix.errors",
    "MissingExtraError": "tactfix.errors",
    "NotLocatedError": "tactfix.errors",
    "NotQualifiedError": "tactfix.errors",
    "OtherFixtureError": "tactfix.errors",
    "PoseRefusedError": "tactfix.errors",
    "TipDoesNotFitError": "tactfix.errors",
    "TactfixError": "tactfix.errors",
    "UsageError": "tactfix.errors",
    "Wishes": "tactfix.design.design_report",
    "batch": "tactfix.records",
    "html_report": "tactfix.records",
    "check": "tactfix.monitoring.check",
    "compare": "tactfix.pose_formats.comparison",
    "contacts_from_arrays": "tactfix.contact_arrays",
    "cylinders_through_five": "tactfix.stacks.five_contact_cylinders",
    "design_check": "tactfix.design.design_check",
    "fit": "tactfix.fitting.fit",
    "guide": "tactfix.monitoring.guide",
    "load_contacts": "tactfix.files.contact_source",
    "load_fixture": "tactfix.files.fixture_file",
    "load_pose": "tactfix.files.pose_file",
    "locate": "tactfix.localization.locate",
    "plan": "tactfix.planning.plan",
    "qualify": "tactfix.qualification.qualify",
    "simulate": "tactfix.simulation.simulate",
    "sphere_centers": "tactfix.stacks.sphere_centers",
    "write_pose": "tactfix.pose_formats.convert",
}
"""The module in which each public name is defined."""


def __getattr__(name: str) -> object:
    """A public name, from the module that defines it."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """The public names, whether asked for yet or not."""
    return list(__all__)
