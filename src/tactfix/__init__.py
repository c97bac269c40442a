"""tactfix: where a fixture stands, from a handful of touches.

What __all__ names is the public API. Each name is imported when it is first asked for, so that `import tactfix` costs
next to nothing:

    fixture = tactfix.load_fixture("fixtures/cylinder-sphere.yaml")
    contacts = tactfix.load_contacts("samples/cylinder-sphere/contacts.csv", fixture)
    result = tactfix.locate(fixture, contacts)
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

from tactfix.version import VERSION

if TYPE_CHECKING:
    from tactfix.compare import Movement, compare
    from tactfix.contacts import Contacts, contacts_from_arrays
    from tactfix.convert import write_pose
    from tactfix.design_check import DesignReport, Wishes, design_check
    from tactfix.dialects.pose import Pose
    from tactfix.errors import FileError, TactfixError, UsageError
    from tactfix.files.contact_file import load_contacts
    from tactfix.files.contact_options import ContactOptions
    from tactfix.files.fixture_file import load_fixture
    from tactfix.files.pose_file import load_pose
    from tactfix.fit import fit
    from tactfix.fitting.result import FitResult
    from tactfix.fixture import Fixture
    from tactfix.localizers.five_contact_cylinders import CylinderStack, cylinders_through_five
    from tactfix.localizers.sphere_centers import SphereCenters, sphere_centers
    from tactfix.locate import locate
    from tactfix.mistakes.faults import Fault
    from tactfix.plan import plan
    from tactfix.planning.result import Plan
    from tactfix.results import LocateResult
    from tactfix.simulate import Simulation, simulate

__version__ = VERSION

__all__ = [
    "ContactOptions",
    "Contacts",
    "CylinderStack",
    "DesignReport",
    "Fault",
    "FileError",
    "FitResult",
    "Fixture",
    "LocateResult",
    "Movement",
    "Plan",
    "Pose",
    "Simulation",
    "SphereCenters",
    "TactfixError",
    "UsageError",
    "Wishes",
    "__version__",
    "compare",
    "contacts_from_arrays",
    "cylinders_through_five",
    "design_check",
    "fit",
    "load_contacts",
    "load_fixture",
    "load_pose",
    "locate",
    "plan",
    "simulate",
    "sphere_centers",
    "write_pose",
]

_HOMES = {
    "ContactOptions": "tactfix.files.contact_options",
    "Contacts": "tactfix.contacts",
    "CylinderStack": "tactfix.localizers.five_contact_cylinders",
    "DesignReport": "tactfix.design_check",
    "Fault": "tactfix.mistakes.faults",
    "FileError": "tactfix.errors",
    "FitResult": "tactfix.fitting.result",
    "Fixture": "tactfix.fixture",
    "LocateResult": "tactfix.results",
    "Movement": "tactfix.compare",
    "Plan": "tactfix.planning.result",
    "Pose": "tactfix.dialects.pose",
    "Simulation": "tactfix.simulate",
    "SphereCenters": "tactfix.localizers.sphere_centers",
    "TactfixError": "tactfix.errors",
    "UsageError": "tactfix.errors",
    "Wishes": "tactfix.design_check",
    "compare": "tactfix.compare",
    "contacts_from_arrays": "tactfix.contacts",
    "cylinders_through_five": "tactfix.localizers.five_contact_cylinders",
    "design_check": "tactfix.design_check",
    "fit": "tactfix.fit",
    "load_contacts": "tactfix.files.contact_file",
    "load_fixture": "tactfix.files.fixture_file",
    "load_pose": "tactfix.files.pose_file",
    "locate": "tactfix.locate",
    "plan": "tactfix.plan",
    "simulate": "tactfix.simulate",
    "sphere_centers": "tactfix.localizers.sphere_centers",
    "write_pose": "tactfix.convert",
}
"""The module in which each public name is defined."""


class _Package(ModuleType):
    """The package itself: tactfix.locate is the function, also once the module of that name has been imported.

    Importing a submodule makes it an attribute of its package. Where a public function has the same name, whether
    tactfix.locate could be called would hang on what had been imported before.
    """

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _HOMES and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


def __getattr__(name: str) -> object:
    """A public name, from the module that defines it."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """The public names, whether asked for yet or not."""
    return list(__all__)
