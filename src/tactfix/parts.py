"""The types of the parts of public values: for annotations, match statements and isinstance.

    from tactfix.parts import Diagnosis

    def worst(causes: tuple[Diagnosis, ...]) -> Diagnosis: ...

They need not be constructed: they are parts of a `LocateResult`, a `DesignReport`, a `Fixture` and so on. CheckDrift is
the drift over checks of a fixture, TouchDrift that over touches of one place.
"""

from tactfix.calibration.cell import Cell, Place, Prior
from tactfix.calibration.result import (
    FactorScore,
    LeftOut,
    ParameterResult,
    PlaceResult,
    TipResult,
    TouchResidual,
    Workspace,
)
from tactfix.design.accuracy import Certainty, Influence, Observability, PointSigma
from tactfix.design.blind_spot import BlindSpot
from tactfix.design.contact_counts import ContactCounts, FeatureCounts
from tactfix.design.cylinder_layouts import CylinderLayout
from tactfix.design.findings import Finding
from tactfix.design.margins import Fragile, Margins, Rival
from tactfix.design.pose_counts import PoseCount
from tactfix.design.random_layouts import LayoutStudy, RealPoses, UniqueShare
from tactfix.design.symmetries import Symmetry
from tactfix.files.cell_file import DhRobot
from tactfix.fitting.result import FitCandidate
from tactfix.fixture import AxisRule, FrameRecipe, OriginRule, Relation, TouchBox
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere
from tactfix.kinematics.chain import Chain, ElementaryMotion, FixedMotion, Joint, Parameter, TipMotion
from tactfix.kinematics.denavit_hartenberg import Row
from tactfix.kinematics.urdf import UrdfRobot
from tactfix.kinematics.urdf_syntax import UrdfJoint
from tactfix.monitoring.check import WorstPoint
from tactfix.monitoring.drift import Drift as CheckDrift
from tactfix.planning.result import PlanStep
from tactfix.pose_formats.convert import Written
from tactfix.qualification.result import DirectionMean, Step
from tactfix.qualification.result import Drift as TouchDrift
from tactfix.results import (
    Candidate,
    ContactResidual,
    Diagnosis,
    FreeMotion,
    JsonResult,
    NextContact,
    Reason,
    TipEstimate,
    Touched,
    WithoutPrior,
)

__all__ = [
    "AxisRule",
    "BlindSpot",
    "Candidate",
    "Cell",
    "Certainty",
    "Chain",
    "CheckDrift",
    "ContactCounts",
    "ContactResidual",
    "Cylinder",
    "CylinderLayout",
    "DhRobot",
    "Diagnosis",
    "DirectionMean",
    "ElementaryMotion",
    "FactorScore",
    "FeatureCounts",
    "Finding",
    "FitCandidate",
    "FixedMotion",
    "Fragile",
    "FrameRecipe",
    "FreeMotion",
    "Influence",
    "Joint",
    "JsonResult",
    "LayoutStudy",
    "LeftOut",
    "Margins",
    "NextContact",
    "Observability",
    "OriginRule",
    "Parameter",
    "ParameterResult",
    "Place",
    "PlaceResult",
    "PlanStep",
    "Plane",
    "Point",
    "PointSigma",
    "PoseCount",
    "Prior",
    "RealPoses",
    "Reason",
    "Relation",
    "Rival",
    "Row",
    "Sphere",
    "Step",
    "Symmetry",
    "TipEstimate",
    "TipMotion",
    "TipResult",
    "TouchBox",
    "TouchDrift",
    "TouchResidual",
    "Touched",
    "UniqueShare",
    "UrdfJoint",
    "UrdfRobot",
    "WithoutPrior",
    "Workspace",
    "WorstPoint",
    "Written",
]
