"""Contacts as machines log them: machine tools, measuring machines, robots."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from tactfix.files.logs.abb import read_abb
from tactfix.files.logs.dmis import read_dmis
from tactfix.files.logs.fanuc import read_fanuc
from tactfix.files.logs.grbl import read_grbl
from tactfix.files.logs.ippdme import read_ippdme
from tactfix.files.logs.kuka import read_kuka
from tactfix.files.logs.linuxcnc import read_linuxcnc
from tactfix.files.logs.log import LogFormat
from tactfix.files.logs.msr import read_msr
from tactfix.files.logs.ur import read_ur
from tactfix.files.logs.xyz import read_xyz, read_xyzijk
from tactfix.formats import LOG_NAMES

_WORK_SYSTEM: Final = "the active work coordinates"
_PART_SYSTEM: Final = "the active part coordinate system"

_LOGS_MADE: Final = {
    log.name: log
    for log in (
        LogFormat("linuxcnc", "LinuxCNC PROBEOPEN log: X Y Z A B C U V W a line", read_linuxcnc, frame=_WORK_SYSTEM),
        LogFormat(
            "grbl",
            "consoles of grbl, TinyG, Marlin: [PRB:x,y,z:1], prb in JSON, Bed X: Y: Z:; misses are dropped",
            read_grbl,
        ),
        LogFormat("msr", "MSR results file: G800 nominal with normal, G801 measured", read_msr, frame=_WORK_SYSTEM),
        LogFormat(
            "xyzijk",
            "PC-DMIS XYZIJK: inch unless METRIC, outward normals",
            read_xyzijk,
            compensated=True,
            frame=_PART_SYSTEM,
        ),
        LogFormat("xyz", "points, or points with the outward normal, a line each", read_xyz, compensated=True),
        LogFormat("ippdme", "I++ DME answers: # X(), Y(), Z(), IJK(), ER(); mm", read_ippdme, frame=_PART_SYSTEM),
        LogFormat("dmis", "DMIS: PTMEAS/CART,x,y,z,i,j,k", read_dmis, compensated=True, frame=_PART_SYSTEM),
        LogFormat("ur", "Universal Robots: p[x, y, z, rx, ry, rz], columns, RTDE recorder; m and rad", read_ur),
        LogFormat(
            "kuka",
            "KUKA positions: {X, Y, Z, A, B, C}, .dat, columns; mm and degrees",
            read_kuka,
            frame="the active base",
        ),
        LogFormat("abb", "ABB robtargets, .mod, columns; mm and quaternions", read_abb, frame="the active work object"),
        LogFormat(
            "fanuc",
            "FANUC positions, .ls, registers, columns; mm and degrees",
            read_fanuc,
            frame="the active user frame",
        ),
    )
}
LOG_FORMATS: Final[Mapping[str, LogFormat]] = MappingProxyType({name: _LOGS_MADE[name] for name in LOG_NAMES})
"""Machine logs by name, as in --contacts-format; csv, tactfix's own contact file, is not among them."""
