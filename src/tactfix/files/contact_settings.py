"""The settings of a contact file, "# key: value" lines above its header row, and advice for misspelt ones."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from tactfix.decimal_text import DECIMAL_COMMA, NUMBER, number_of
from tactfix.errors import Problem
from tactfix.files.contact_options import ContactOptions
from tactfix.units import LEAST_LENGTH, MOST_LENGTH, UNITS, which_unit

SETTING_KEYS: Final = ("units", "tip_radius", "sigma", "pose", "tip_offset")
_SETTING_EXAMPLES: Final = {"units": "mm", "tip_radius": "1.5", "sigma": "0.005", "tip_offset": "0, 0, 120"}
_DIAMETER: Final = "tip_diameter"
"""A key often given instead of tip_radius; the message gives half the value."""
_SYNONYMS: Final[dict[str, str]] = {
    **dict.fromkeys(("unit", "length_unit", "length_units", "einheit"), "units"),
    **dict.fromkeys(("tip", "tipradius", "radius", "probe_radius", "stylus_radius", "ball_radius"), "tip_radius"),
    **dict.fromkeys(("sigmas", "std", "stddev", "uncertainty", "\u03c3"), "sigma"),
    **dict.fromkeys(("tcp", "tcp_offset", "tool_offset", "tipoffset", "probe_offset"), "tip_offset"),
    **dict.fromkeys(("diameter", "tip_dia", "ball_diameter", "probe_diameter", "stylus_diameter"), _DIAMETER),
}
_LONGEST_KEY: Final = 20
"""Longest text, in characters, taken for a mistyped key."""
_KEY: Final = re.compile(r"[A-Za-z][\w-]*(?: [A-Za-z]+)?")
"""A key of one or two words; more words before a colon are a plain comment."""
_TOKEN: Final = re.compile(rf"[^\W\d]\w*?(?:-[^\W\d]\w*?)*(?=[\W\d]|$)|(?:{NUMBER.pattern})")
"""A word, or a number; a word ends where a digit begins, as in sigma0.005."""
_WEIGHTLESS: Final = frozenset(("is", "of", "a", "an", "the", "to", "and", "x", "y", "z", "one", "as", "equals"))
_LONGEST_SETTING: Final = 80
"""Longest line, in characters, taken for a setting in words; a longer one is a comment."""
_PADDING: Final = ",; \t"
"""Characters that spreadsheets add to the end of a line."""


@dataclass(slots=True)
class SettingLines:
    """The settings in the lines of a file; what is wrong with them is appended to problems.

    values: text and line number by key. attempted: keys that a faulty line was meant to set, which has been reported.
    """

    problems: list[Problem]
    values: dict[str, tuple[str, int]] = field(default_factory=dict)
    attempted: set[str] = field(default_factory=set)

    @property
    def keys(self) -> frozenset[str]:
        """The keys that lines set, or were meant to set."""
        return frozenset(self.values) | self.attempted

    def read(self, line: str, number: int) -> None:
        """Read the setting in a comment line, which begins with #; a plain comment has none."""
        key, value = _key_and_value(line) or ("", "")
        if key.lower() in SETTING_KEYS:
            self._set(key.lower(), value, number)
            return
        near = _nearly_setting(line, key, value)
        if near:
            setting, message, remedy = near
            self.attempted.add(setting)
            self.problems.append(Problem(message, remedy, line=number))

    def _set(self, key: str, value: str, number: int) -> None:
        if key in self.values:
            message = f"{key} is given twice, first in line {self.values[key][1]}"
            self.problems.append(Problem(message, "remove one of the two", line=number))
        self.values.setdefault(key, (value, number))

    def read_units_of_columns(self, units: Sequence[str], number: int) -> None:
        """Use the units after the names of columns in this line as the unit of the file."""
        known = self.values.get("units", (units[0], number))
        other = next((unit for unit in units if unit != known[0]), None)
        if other is None:
            self.values["units"] = known
            return
        self.attempted.add("units")
        rest = f"line {known[1]} says {known[0]!r}" if "units" in self.values else f"another in {known[0]!r}"
        remedy = "all lengths of a file are in one unit: write '# units: mm'"
        self.problems.append(Problem(f"a column is in {other!r}, {rest}", remedy, line=number))

    def settings(self, separator: str) -> ContactOptions:
        """The settings; an invalid value is a problem and counts as not given."""
        units, line = self.values.get("units", (None, 0))
        if units is not None and units not in UNITS:
            self.problems.append(Problem(f"units is {_shown(units)}", which_unit(units), line=line))
            units = None
        return ContactOptions(
            units,
            self._length("tip_radius", separator),
            self._length("sigma", separator),
            self._offset(separator),
            of_flange=self._pose() == "flange",
        )

    def _pose(self) -> str:
        pose, line = self.values.get("pose", ("tip", 0))
        if pose not in ("tip", "flange"):
            remedy = "write 'flange' if x, y, z are the origin of the flange, 'tip' if they are the tip's centre"
            self.problems.append(Problem(f"pose is {_shown(pose)}", remedy, line=line))
        return pose

    def _offset(self, separator: str) -> tuple[float, float, float] | None:
        if "tip_offset" not in self.values:
            return None
        text, line = self.values["tip_offset"]
        mark = ";" if ";" in text else ","
        values = [_number(part.strip(), ";" if mark == ";" else separator) for part in text.strip("()[]").split(mark)]
        if len(values) == 3 and all(abs(value) <= MOST_LENGTH for value in values):
            return values[0], values[1], values[2]
        remedy = "write the tip's centre in the flange frame as x, y, z in the units of this file"
        self.problems.append(Problem(f"tip_offset is {_shown(text)}", remedy, line=line))
        return None

    def _length(self, key: str, separator: str) -> float | None:
        if key not in self.values:
            return None
        text, line = self.values[key]
        value = _number(text, separator)
        if LEAST_LENGTH <= value <= MOST_LENGTH or (value == 0 and key == "tip_radius"):
            return value
        least = "of at least 0" if key == "tip_radius" else "above 0"
        remedy = f"write a number {least} in the units of this file, without its unit"
        if DECIMAL_COMMA.fullmatch(text):
            remedy = f"write a decimal point: {text.replace(',', '.')}"
        self.problems.append(Problem(f"{key} is {_shown(text)}", remedy, line=line))
        return None


def _number(text: str, separator: str) -> float:
    """A decimal number, with a decimal comma too unless the comma is the separator; nan for anything else."""
    plain = text if separator == "," else text.replace(",", ".")
    value = number_of(plain)
    return float("nan") if value is None else value


def key_of(line: str) -> str | None:
    """The key that a comment line sets, None for a plain comment."""
    key, _ = _key_and_value(line) or ("", "")
    return key.lower() if key.lower() in SETTING_KEYS else None


def _key_and_value(line: str) -> tuple[str, str] | None:
    """Both sides of "# key: value" or "# key = value", in time linear in its length."""
    text = line[1:].lstrip()
    at = min((place for place in (text.find(":"), text.find("=")) if place >= 0), default=-1)
    key = text[: max(at, 0)].rstrip()
    return (key, text[at + 1 :].strip().rstrip(_PADDING)) if _KEY.fullmatch(key) else None


def _nearly_setting(line: str, key: str, value: str) -> tuple[str, str, str] | None:
    """The key that a misspelt setting was meant to set, what is wrong, and what to write instead; None for a comment.

    key and value: both sides of its colon, empty if it has none.
    """
    near = _nearest_key(key) if key else None
    if near == _DIAMETER:
        return "tip_radius", f"unknown key {key!r}", _half(value)
    if near:
        return near, f"unknown key {key!r}", f"did you mean {near!r}?"
    return None if len(line) > _LONGEST_SETTING else _setting_in_words(line)


def _setting_in_words(line: str) -> tuple[str, str, str] | None:
    """The same for a name and a value with other marks or filler words between or around them.

    A comment with any other word is a sentence, and sets nothing.
    """
    text = line.lstrip("# \t").rstrip(_PADDING)
    words = [word for word in _TOKEN.findall(text) if word.lower() not in _WEIGHTLESS]
    names = [word for word in words if not NUMBER.fullmatch(word) and not _is_unit(word)]
    numbers, units = [word for word in words if NUMBER.fullmatch(word)], list(filter(_is_unit, words))
    if not names and units and len(units) + len(numbers) == len(words):
        near: str | None = "units"
    else:
        near = _nearest_key(" ".join(names[:2])) if words[: len(names)] == names and 0 < len(names) < 3 else None
    if near is None or not (units if near == "units" else numbers):
        return None
    alone = line.lstrip("#") == line[1:]
    message = f"{_shown(text)} sets nothing: " + ("it is no '# key: value'" if alone else "a setting begins with one #")
    if near == _DIAMETER:
        return "tip_radius", message, _half(numbers[0])
    value = (
        next((unit for unit in reversed(units) if unit in UNITS), _SETTING_EXAMPLES[near])
        if near == "units"
        else numbers[0]
    )
    if near == "tip_offset":
        value = _SETTING_EXAMPLES[near] if len(numbers) != 3 else ", ".join(numbers)
    return near, message, f"write '# {near}: {value}'; '# units: mm' gives the unit of all lengths"


def _is_unit(word: str) -> bool:
    return word in UNITS or which_unit(word).startswith("did you mean")


def _half(diameter: str) -> str:
    """Advice for a tip diameter: write half of it as the radius."""
    return f"write '# tip_radius: {(number_of(diameter) or 3.0) / 2:g}', half of the diameter"


def _nearest_key(key: str) -> str | None:
    """The key of which this text is a synonym or misspelling; None for the first word of a plain comment."""
    from difflib import get_close_matches

    plain = key.lower().replace("-", "_").replace(" ", "_")
    # Not "pose": "probe" and "note" are similar to it, and begin plain comments.
    known = [key for key in (*SETTING_KEYS, _DIAMETER) if key != "pose"]
    near = get_close_matches(plain, known, n=1, cutoff=0.8) if len(plain) <= _LONGEST_KEY else []
    return _SYNONYMS.get(plain) or (near[0] if near else None)


def _shown(text: str) -> str:
    return repr(text if len(text) <= 40 else f"{text[:40]}...")
