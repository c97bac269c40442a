"""tactfix: locate a fixture from a handful of touches.

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

`help(tactfix.locate)` documents one of them; tactfix.parts has the types of the parts of results. Lengths are in the
unit of the fixture, angles in rad, poses are base_from_fixture. Each name is imported on first access, so that
`import tactfix` is fast.
"""

from tactfix.version import VERSION

# Not imported from typing, whose import takes longer than all else before the command line can handle a Ctrl-C.
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

_NAMES_OF = {
    "batching.row": "BatchRow",
    "calibration.cell": "Touches",
    "calibration.result": "Calibration",
    "contact_arrays": "contacts_from_arrays",
    "contacts": "Contacts",
    "design.design_check": "design_check",
    "design.design_report": "DesignReport Wishes",
    "errors": (
        "DegenerateContactsError FileError MissingExtraError NotLocatedError NotQualifiedError OtherFixtureError "
        "PoseRefusedError Problem TactfixError TipDoesNotFitError UsageError"
    ),
    "feature": "Feature",
    "files.cell_file": "CellFile load_cell",
    "files.contact_options": "ContactOptions",
    "files.contact_source": "load_contacts",
    "files.fixture_file": "load_fixture",
    "files.pose_file": "load_pose",
    "files.robot_file": "write_robot",
    "fitting.fit": "fit",
    "fitting.result": "FitResult",
    "fixture": "Fixture Probe",
    "localization.locate": "locate",
    "locate_result": "LocateResult LocatedResult NotLocatedResult",
    "monitoring.check": "CheckResult check",
    "monitoring.drift": "CheckRecord",
    "monitoring.guide": "GuideStep guide",
    "placement": "Placement",
    "planning.plan": "plan",
    "planning.result": "Plan",
    "pose_formats.comparison": "Limits Movement compare",
    "pose_formats.convert": "write_pose",
    "pose_formats.pose": "Pose",
    "qualification.qualify": "qualify",
    "qualification.result": "QualifyResult",
    "records": "batch calibrate html_report load_touches",
    "simulation.faults": "Fault",
    "simulation.simulate": "Simulation simulate",
    "stacks.five_contact_cylinders": "CylinderStack cylinders_through_five",
    "stacks.sphere_centers": "SphereCenters sphere_centers",
}
"""The public names of each module."""
_HOMES = {name: f"tactfix.{module}" for module, names in _NAMES_OF.items() for name in names.split()}


def __getattr__(name: str) -> object:
    """A public name, from the module that defines it."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """The public names, whether imported yet or not."""
    return list(__all__)
