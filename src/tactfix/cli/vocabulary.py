"""Names that help and completion tell, written down here so that telling them imports nothing.

The tests hold them to what they name.
"""

from typing import Final

POSE_FORMATS: Final = (
    "matrix",
    "json",
    "yaml",
    "csv",
    "npy",
    "ros",
    "ros-static",
    "urdf",
    "kuka",
    "abb",
    "abb-wobjdata",
    "fanuc",
    "ur",
    "yaskawa",
    "staubli",
    "mecademic",
    "kawasaki",
    "comau",
    "doosan",
    "mitsubishi",
    "siemens",
    "heidenhain",
    "g68.2",
    "g10",
)
"""The keys of tactfix.pose_formats.DIALECTS."""

CONTACT_FORMATS: Final = ("linuxcnc", "grbl", "msr", "xyzijk", "ippdme", "ur", "kuka")
"""The keys of tactfix.files.logs.LOG_FORMATS."""

FAULTS: Final = (
    "outlier",
    "reversed-approach",
    "swapped-labels",
    "wrong-unit",
    "forgotten-tip",
    "late-trigger",
    "thermal-growth",
)
"""tactfix.simulation.faults.FAULT_KINDS."""

LEVER_ARM_MM: Final = 500.0
"""tactfix.convert.LEVER_ARM_MM."""
