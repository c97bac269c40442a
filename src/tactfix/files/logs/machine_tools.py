"""Logs of machine tools: LinuxCNC PROBEOPEN, grbl probe reports, MSR result files."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from tactfix.errors import Problem
from tactfix.files.logs.log import NUMBER, Log, LogContact, Vector, against, numbers_in, passed_over, vector

_PRB: Final = re.compile(r"\[PRB:([^:\]]*):([01])\]")
_WORD: Final = re.compile(rf"([A-Z])\s*({NUMBER})")
_STILL: Final = "move it back, or log the contacts of one position of these axes in a file of their own"


def read_linuxcnc(lines: Sequence[str], problems: list[Problem]) -> Log:
    """(PROBEOPEN name): nine numbers a line, X Y Z A B C U V W of the tip's centre; only hits are written."""
    contacts: list[LogContact] = []
    others: tuple[float, ...] | None = None
    for number, line in enumerate(lines, 1):
        words = line.split()
        if not words:
            continue
        axes = numbers_in(words, 9)
        if axes is None:
            problems.append(Problem("is not X Y Z A B C U V W", "write nine numbers with blanks between", line=number))
            continue
        if others is not None and axes[3:] != others:
            problems.append(Problem("A B C U V W differ from those of the lines before", _STILL, line=number))
        others = axes[3:] if others is None else others
        contacts.append(LogContact(number, vector(axes[:3])))
    notes = () if others is None or not any(others) else (f"A B C U V W stand at {others} throughout",)
    return Log(tuple(contacts), notes=notes)


def read_grbl(lines: Sequence[str], problems: list[Problem]) -> Log:
    """[PRB:x,y,z:1] for a hit, in machine coordinates; [PRB:...:0] is a miss and dropped. The rest is talk."""
    contacts: list[LogContact] = []
    misses: list[int] = []
    talk: list[int] = []
    for number, line in enumerate(lines, 1):
        report = _PRB.fullmatch(line.strip())
        if report is None:
            if "PRB" in line.upper():
                problems.append(Problem("is not a whole probe report", "write [PRB:x,y,z:1]", line=number))
            elif line.strip():
                talk.append(number)
            continue
        words = report.group(1).split(",")
        axes = numbers_in(words, max(3, len(words)))
        if axes is None:
            problems.append(Problem("does not hold x,y,z as numbers", "write [PRB:x,y,z:1]", line=number))
        elif report.group(2) == "0":
            misses.append(number)
        else:
            contacts.append(LogContact(number, vector(axes[:3])))
    notes = (*_misses(misses), *passed_over(talk, "lines that are no probe reports"))
    return Log(tuple(contacts), notes=notes)


def _misses(lines: Sequence[int]) -> tuple[str, ...]:
    return tuple(f"line {line}: the probe met nothing; dropped" for line in lines)


@dataclass(slots=True)
class _Nominals:
    """What an MSR file has said so far: nominal normals by point name, those not yet measured, the rotary position."""

    normals: dict[str, Vector | None] = field(default_factory=dict)
    waiting: dict[str, int] = field(default_factory=dict)
    rotary: tuple[float, ...] | None = None


def read_msr(lines: Sequence[str], problems: list[Problem]) -> Log:
    """G800 N X Y Z I J K: nominal point and outward normal; G801 N X Y Z R: the tip's centre measured, its radius."""
    contacts: list[LogContact] = []
    nominals = _Nominals()
    other: list[int] = []
    notes: list[str] = []
    for number, line in enumerate(lines, 1):
        words = {letter: float(value) for letter, value in _WORD.findall(line.upper())}
        match int(words.get("G", 0)):
            case 330:
                _rotary(nominals, words, number, problems)
            case 800:
                _nominal(nominals, words, number, problems)
            case 801:
                contacts.extend(_measured(nominals, words, number, problems, notes))
            case _ if line.strip() and line.strip().upper() not in ("START", "END"):
                other.append(number)
    notes += [f"line {line}: point {name} has no measurement; dropped" for name, line in nominals.waiting.items()]
    return Log(tuple(contacts), notes=(*notes, *passed_over(other, "lines other than G330, G800, G801")))


def _rotary(nominals: _Nominals, words: Mapping[str, float], line: int, problems: list[Problem]) -> None:
    """G330: where the rotary axes stand; points measured at different positions are not in one frame."""
    angles = tuple(words.get(axis, 0.0) for axis in "ABC")
    if nominals.rotary is not None and angles != nominals.rotary:
        problems.append(Problem("A B C differ from those of the G330 before", _STILL, line=line))
    nominals.rotary = angles


def _nominal(nominals: _Nominals, words: Mapping[str, float], line: int, problems: list[Problem]) -> None:
    """G800: remember the normal of a point that G801 will name."""
    if not {"N", "I", "J", "K"} <= words.keys():
        problems.append(Problem("G800 without N, I, J, K", "write N and the outward normal", line=line))
        return
    name = f"N{words['N']:g}"
    nominals.normals[name] = against([words[axis] for axis in "IJK"])
    nominals.waiting[name] = line


def _measured(
    nominals: _Nominals, words: Mapping[str, float], line: int, problems: list[Problem], notes: list[str]
) -> list[LogContact]:
    """G801: one contact, with the approach of its G800."""
    if not {"N", "X", "Y", "Z"} <= words.keys():
        problems.append(Problem("G801 without N, X, Y, Z", "write N and the measured centre of the tip", line=line))
        return []
    name = f"N{words['N']:g}"
    if nominals.waiting.pop(name, None) is None:
        notes.append(f"line {line}: point {name} has no G800 before it, and so no approach")
        nominals.normals[name] = None
    point = vector([words[axis] for axis in "XYZ"])
    return [LogContact(line, point, nominals.normals[name], tip_radius=words.get("R"), id=name)]
