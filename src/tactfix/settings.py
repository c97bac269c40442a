"""Settings by name in messages: an option on the command line, a keyword argument in Python.

A message is a str. If it names a setting, it is a `Wording`: the str itself is the text for Python callers, and
`on_command_line` is the same message with options. `+` and `joined` keep both; nothing translates one into the other.
"""

import shlex
from collections.abc import Iterable
from enum import Enum
from typing import Final


class Wording(str):
    """A text for Python callers, with the equivalent text for the command line."""

    on_command_line: str

    def __new__(cls, python: str, on_command_line: str) -> "Wording":
        """Keep both texts."""
        made = super().__new__(cls, python)
        made.on_command_line = on_command_line
        return made

    def __add__(self, after: str) -> "Wording":
        return Wording(str(self) + str(after), self.on_command_line + on_command_line(after))

    def __radd__(self, before: str) -> "Wording":
        return Wording(before + str(self), before + self.on_command_line)

    def __reduce__(self) -> tuple[object, ...]:
        return Wording, (str(self), self.on_command_line)


def on_command_line(text: str) -> str:
    """The text as the command line prints it."""
    return text.on_command_line if isinstance(text, Wording) else text


def joined(separator: str, texts: Iterable[str]) -> str:
    """str.join that keeps both wordings."""
    texts = list(texts)
    return Wording(separator.join(texts), separator.join(map(on_command_line, texts)))


class Setting(Enum):
    """A setting: the option of the command line, and the keyword argument of Python."""

    APPROACH = "--approach", "approach"
    DIALECT = "--from", "dialect"
    FEATURES = "--features", "features"
    FORCE = "--force", "force"
    LOG_FORMAT = "--contacts-format", "format"
    ORIENTATIONS = "--orientations", "orientations"
    REPEATS = "--repeats", "repeats"
    SIGMA = "--sigma", "sigma"
    TIP_OFFSET = "--tip-offset", "tip_offset"
    TIP_RADIUS = "--tip-radius", "tip_radius"
    UNITS = "--units", "units"
    UNKNOWN = "--unknown", "unknown"
    WORK_OFFSET = "--work-offset", "work_offset"

    @property
    def word(self) -> Wording:
        """The setting without a value: --sigma, sigma=."""
        option, keyword = self.value
        return Wording(f"{keyword}=", option)

    def to(self, value: str | float) -> Wording:
        """The setting with a value: --units mm, units="mm"."""
        option, keyword = self.value
        if isinstance(value, str):
            return Wording(f'{keyword}="{value}"', f"{option} {shlex.quote(value)}")
        return Wording(f"{keyword}={value:g}", f"{option} {value:g}")


FOR_LOGS: Final = (
    joined(", ", [Setting.FEATURES.word, Setting.APPROACH.word, Setting.REPEATS.word])
    + " and "
    + Setting.WORK_OFFSET.word
    + " are for machine logs; name theirs with "
    + Setting.LOG_FORMAT.word
)
"""The error if one of them is given for a contact file, which contains this information."""
LOCATE_JSON: Final = Wording("what result.to_json() gives", "the output of locate --json")
"""A located pose in a file, by what writes it."""
ONE_FEATURE: Final = Wording("take those on one with contacts.on(name)", "choose one with --feature")
"""How contacts on several features become those on one."""
