"""Results built by hand, for tests of reports and the command line, without a solver."""

from importlib import import_module

import numpy as np

from tactfix.geometry.surfaces import Cylinder, Plane, Sphere
from tactfix.locate_result import LocateResult
from tactfix.results import Candidate, ContactResidual, Diagnosis, FreeMotion, NextContact, Reason, Status

LOCATING = import_module("tactfix.localization.locate")
"""The module that defines locate; the attribute tactfix.locate is the function."""

BASE_FROM_FIXTURE = np.array(
    [[0.6, -0.8, 0.0, 1 / 3], [0.8, 0.6, 0.0, -2.0e-7], [0.0, -0.0, 1.0, 12345.678901234567], [0.0, 0.0, 0.0, 1.0]]
)
HALF_TURN = BASE_FROM_FIXTURE @ np.diag([1.0, -1.0, -1.0, 1.0])
COVARIANCE = np.diag([1e-6, 2e-6, 3e-6, 4e-4, 5e-4, 6e-4]) ** 2
SURFACES = {
    "ball": Sphere(np.array([1.0, 2.0, 3.0]), 12.7),
    "bar": Cylinder(np.zeros(3), np.array([0.0, 0.0, -2.0]), 1.0, "inner"),
    "top": Plane(np.zeros(3), np.array([0.0, 3.0, 4.0])),
}
FELL = Reason("touch", "bar", 1, "y is -2.3, outside [0.2, 6.0]")


def answer(status: Status = "located", contacts: int = 3) -> LocateResult:
    """A result of this status, with all its parts."""
    located, ambiguous = status == "located", status == "ambiguous"
    reasons = (FELL, Reason("approach", "ball", 2, "it comes out of the material"))
    first = Candidate(BASE_FROM_FIXTURE, SURFACES, 0.3, 1e-4, () if located or ambiguous else reasons)
    second = Candidate(HALF_TURN, SURFACES, 0.3, 1e-4, () if ambiguous else reasons)
    return LocateResult(
        fixture="cell",
        units="mm",
        status=status,
        base_from_fixture=BASE_FROM_FIXTURE if located else None,
        covariance=COVARIANCE if located else None,
        dof=1,
        chi2=0.3,
        chi2_limit=6.63,
        rms=1e-4,
        candidates=(first, second),
        surfaces=SURFACES,
        contacts=tuple(
            ContactResidual(k + 1, "bar", (-1) ** k * 1e-4 * (k + 1) / contacts, None if k == 1 else 10.0 * (k % 9))
            for k in range(contacts)
        ),
        free_motions=(FreeMotion(np.array([0.0, 0.0, 1.0]), np.zeros(3), "turns about the axis of bar"),)
        if status == "underdetermined"
        else (),
        next_contact=NextContact("ball", np.ones(3), np.array([0.0, 0.0, -1.0]), "touch ball from above")
        if ambiguous
        else None,
        warnings=("row 3 is within two sigma of grazing",),
        diagnosis=(Diagnosis("outlier", (3,), ("bar",), 0.7, 0.2, "touch row 3 again"),),
    )
