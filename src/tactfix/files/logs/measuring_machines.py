"""Logs of measuring machines: PC-DMIS XYZIJK files and I++ DME answers. IJK is the outward normal in both."""

import re
from collections.abc import Sequence
from typing import Final

from tactfix.errors import Problem
from tactfix.files.logs.log import Log, LogContact, against, numbers_in, passed_over, vector

_PT_MEAS: Final = re.compile(r"PtMeas\s*\((.*)\)\s*$", re.IGNORECASE)
_PART: Final = re.compile(r"(\w+)\s*\(([^()]*)\)")
_ERROR: Final = re.compile(r"\d+\s*!")


def read_xyzijk(lines: Sequence[str], problems: list[Problem]) -> Log:
    """XYZIJK [METRIC], then x,y,z,i,j,k a line: inch unless METRIC."""
    contacts: list[LogContact] = []
    units: str | None = None
    for number, line in enumerate(lines, 1):
        words = line.replace(",", " ").split()
        if not words:
            continue
        if units is None:
            units = _xyzijk_units(words)
            if units is None:
                problems.append(
                    Problem("does not start with XYZIJK", "write XYZIJK METRIC, or XYZIJK for inch, above", line=number)
                )
                return Log(())
            continue
        values = numbers_in(words, 6)
        if values is None:
            problems.append(Problem("is not x,y,z,i,j,k", "write six numbers", line=number))
        else:
            contacts.append(LogContact(number, vector(values[:3]), against(values[3:])))
    return Log(tuple(contacts), units)


def _xyzijk_units(words: Sequence[str]) -> str | None:
    """The unit that the first line says, None when it is not that line."""
    upper = [word.upper() for word in words]
    if upper[0] != "XYZIJK" or not set(upper[1:]) <= {"METRIC"}:
        return None
    return "mm" if "METRIC" in upper else "in"


def read_ippdme(lines: Sequence[str], problems: list[Problem]) -> Log:
    """'00001 # PtMeas(X(), Y(), Z(), IJK(), R())': what the server answers; lines without # are the dialogue around."""
    contacts: list[LogContact] = []
    talk: list[int] = []
    errors: list[str] = []
    for number, line in enumerate(lines, 1):
        tag, mark, answer = line.partition("#")
        measured = _PT_MEAS.match(answer.strip()) if mark else None
        if _ERROR.match(line.strip()):
            errors.append(f"line {number}: the machine reports an error instead of a contact; dropped")
        elif measured:
            contacts.extend(_pt_meas(measured.group(1), tag.strip(), number, problems))
        elif "ptmeas" in answer.lower():
            problems.append(Problem("is not a whole PtMeas answer", "write PtMeas(X(..), Y(..), Z(..))", line=number))
        elif line.strip():
            talk.append(number)
    return Log(tuple(contacts), notes=(*errors, *passed_over(talk, "lines that are no PtMeas answers")))


def _pt_meas(content: str, tag: str, line: int, problems: list[Problem]) -> list[LogContact]:
    """One contact from the parts of a PtMeas answer."""
    parts = {name.upper(): inside.split(",") for name, inside in _PART.findall(content)}
    point = numbers_in([word for axis in "XYZ" for word in parts.get(axis, ())], 3)
    normal = numbers_in(parts["IJK"], 3) if "IJK" in parts else (0.0, 0.0, 0.0)
    radius = numbers_in(parts["R"], 1) if "R" in parts else (None,)
    if point is None or normal is None or radius is None:
        what = "X(), Y(), Z() are not one number each, or IJK() not three, or R() not one"
        problems.append(Problem(what, "write PtMeas(X(1.0), Y(2.0), Z(3.0), IJK(0,0,1))", line=line))
        return []
    return [LogContact(line, vector(point), against(normal), tip_radius=radius[0], id=tag or None)]
