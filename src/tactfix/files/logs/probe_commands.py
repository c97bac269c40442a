"""The approach of a touch from the probe command before it: G38.2 Z-20 in G91 moves towards -z.

In G90 the words are the end of the move, from which no direction follows without its start. Without G90 or G91 a
command of one axis is taken as incremental, with a note. G38.4 and G38.5 move out of the material.
"""

from dataclasses import dataclass, field
from typing import Final

from tactfix.files.logs.log import Vector
from tactfix.gcode import Block

_TOWARDS_WORK: Final = (38.2, 38.3)
"""G38.2 and G38.3 probe towards the work."""
_OUT_OF: Final = (38.4, 38.5)
"""G38.4 and G38.5 probe away from it."""


@dataclass(slots=True)
class ProbeCommands:
    """Commands heard that no report has answered yet, and the mode that they are meant in."""

    incremental: bool | None = None
    waiting: list[Vector | None] = field(default_factory=list)
    assumed: bool = False
    absolute: bool = False

    def heard(self, block: Block) -> None:
        """A command on a line of its own."""
        if self._probes(block):
            self.waiting.append(self._direction(block))
        else:
            self.mode(block)

    def forget(self) -> None:
        """An alarm: no report will follow."""
        self.waiting.clear()

    def approach(self, command: Block | None) -> Vector | None:
        """The approach of a report: of the command in its own line, else of those that wait, if all say the same."""
        if command is not None and self._probes(command):
            return self._direction(command)
        if not self.waiting:
            return None
        first, same = self.waiting[0], len(set(self.waiting)) == 1
        del self.waiting[0]
        return first if same else None

    def notes(self) -> tuple[str, ...]:
        """What was assumed, or could not be told."""
        notes = []
        if self.assumed:
            notes.append("approaches are read from probe commands, taken as incremental (G91): nothing says which")
        if self.absolute:
            notes.append("probe commands in G90 do not tell the approach; give it")
        return tuple(notes)

    def mode(self, block: Block) -> None:
        """G90 and G91 of a command hold for those that follow."""
        for code in block.codes("G"):
            self.incremental = {90.0: False, 91.0: True}.get(code, self.incremental)

    def _probes(self, block: Block) -> bool:
        return any(code in _TOWARDS_WORK or code in _OUT_OF for code in block.codes("G"))

    def _direction(self, block: Block) -> Vector | None:
        """Unit direction of the probe into the material, None where the command does not determine it."""
        self.mode(block)
        move = [sum(block.codes(axis)) for axis in "XYZ"]
        axes = sum(value != 0 for value in move)
        turns = any(any(block.codes(axis)) for axis in "ABC")
        if axes == 0 or turns or self.incremental is False or (self.incremental is None and axes > 1):
            self.absolute = self.absolute or self.incremental is False
            return None
        self.assumed = self.assumed or self.incremental is None
        sign = -1.0 if any(code in _OUT_OF for code in block.codes("G")) else 1.0
        length = max(abs(value) for value in move)
        x, y, z = (sign * value / length + 0.0 for value in move)
        return x, y, z
