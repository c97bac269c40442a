"""Contacts as machines log them: machine tools, measuring machines, robots."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from tactfix.files.logs.log import LogFormat
from tactfix.files.logs.machine_tools import read_grbl, read_linuxcnc, read_msr
from tactfix.files.logs.measuring_machines import read_ippdme, read_xyzijk
from tactfix.files.logs.robots import pose_line_reader

LOG_FORMATS: Final[Mapping[str, LogFormat]] = MappingProxyType(
    {
        log.name: log
        for log in (
            LogFormat("linuxcnc", "LinuxCNC PROBEOPEN log: X Y Z A B C U V W a line", read_linuxcnc),
            LogFormat("grbl", "grbl probe reports: [PRB:x,y,z:1]; misses are dropped", read_grbl),
            LogFormat("msr", "MSR result file: G800 nominal with normal, G801 measured", read_msr),
            LogFormat("xyzijk", "PC-DMIS XYZIJK: inch unless METRIC, outward normals", read_xyzijk, compensated=True),
            LogFormat("ippdme", "I++ DME answers: # PtMeas(X(), Y(), Z(), IJK(), R())", read_ippdme),
            LogFormat(
                "ur", "Universal Robots: p[x, y, z, rx, ry, rz] or six columns, m and rad", pose_line_reader("ur")
            ),
            LogFormat("kuka", "KUKA: {X, Y, Z, A, B, C} or six columns, mm and degrees", pose_line_reader("kuka")),
        )
    }
)
"""Machine logs by name, as in --contacts-format; csv, tactfix's own contact file, is not among them."""
