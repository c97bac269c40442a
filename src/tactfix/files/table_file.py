"""Tables of many contact sets, CSV or parquet: a contact file with one more column, set.

Each set is converted to the text of a contact file of its own, so that contacts are read and checked by the same code.
"""

import csv
import io
import math
from array import array
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from tactfix.batching.task import ContactSet
from tactfix.errors import FileError, MissingExtraError, Problem
from tactfix.files.contact_header import read_header, split_header
from tactfix.files.contact_settings import SETTING_KEYS, key_of
from tactfix.files.reading import lines_of, read_bytes
from tactfix.geometry.arrays import Ints
from tactfix.values import frozen_value

if TYPE_CHECKING:
    import pyarrow as pa

SET: Final = "set"
_NO_NAME: Final = "the set column is empty; name the set of each contact"


@frozen_value(eq=True)
class CsvTable:
    """Line numbers (from 1) of a table by set, in order of first appearance.

    head: numbers and texts of the lines above the contacts. column: index of the column set; separator: its delimiter.
    """

    head: tuple[tuple[int, str], ...]
    lines: Sequence[str]
    separator: str
    column: int
    sets: Mapping[str, "array[int]"]

    def __len__(self) -> int:
        return len(self.sets)

    def __iter__(self) -> Iterator[ContactSet]:
        for name, numbers in self.sets.items():
            if not name:
                yield ContactSet(name, unreadable=f"line {numbers[0]}: {_NO_NAME}")
                continue
            rows = [(number, _without(self.lines[number - 1], self.separator, self.column)[1]) for number in numbers]
            places, texts = zip(*self.head, *rows, strict=True)
            yield ContactSet(name, "\n".join(texts).encode(), lines=places)


def is_table(text: str) -> bool:
    """Whether the header row of a CSV text has a column set."""
    return _place_of_set(text.splitlines()) is not None


def csv_table(name: str, text: str) -> CsvTable:
    """The sets of a CSV text whose header row has a column set; name: of the table, for messages.

    Rows of one set need not be adjacent. Errors in a row are reported when its set is read.
    Raises FileError for a header that is not valid in a contact file.
    """
    lines = lines_of(text)
    place = _place_of_set(lines)
    assert place is not None
    header, separator, column = place
    problems: list[Problem] = []
    head = [(number, line) for number, line in enumerate(lines[:header], 1) if line.strip()]
    head.append((header + 1, _without(lines[header], separator, column)[1]))
    read_header([line for _, line in head], problems, feature_needed=True)
    # 8-byte integers: a table may have tens of millions of lines.
    sets: defaultdict[str, array[int]] = defaultdict(lambda: array("Q"))
    for number, line in enumerate(lines[header + 1 :], header + 2):
        if line.lstrip().startswith("#"):
            if key_of(line.strip()):
                problems.append(Problem("a setting is below the header row", "move it above", line=number))
        elif line.strip(separator + " \t"):
            sets[_without(line, separator, column)[0]].append(number)
    if not sets:
        problems.append(Problem("there are no contacts", "write one row for each touch below the header row"))
    if problems:
        raise FileError(name, problems)
    return CsvTable(tuple(head), lines, separator, column, sets)


def _place_of_set(lines: Sequence[str]) -> tuple[int, str, int] | None:
    """The index of the header row, its separator and the index of its column set; None if it has none."""
    for index, line in enumerate(lines):
        if line.strip() and not line.lstrip("\ufeff ").startswith("#"):
            separator, names = split_header(line, SET.__eq__)
            return (index, separator, names.index(SET)) if SET in names else None
    return None


def _without(line: str, separator: str, column: int) -> tuple[str, str]:
    """The cell in that column, empty if the row is too short, and the row without it."""
    if '"' not in line:
        cells = line.split(separator)
        name = cells.pop(column).strip() if column < len(cells) else ""
        return name, separator.join(cells)
    cells = next(csv.reader([line], delimiter=separator))
    name = cells.pop(column).strip() if column < len(cells) else ""
    out = io.StringIO()
    csv.writer(out, delimiter=separator, lineterminator="").writerow(cells)
    return name, out.getvalue()


@frozen_value
class ParquetTable:
    """Columns of a table; the rows of set k are rows[starts[k]:starts[k + 1]], in their order in the table."""

    head: str
    columns: tuple[Any, ...]
    names: tuple[str, ...]
    rows: Ints
    starts: Ints

    def __len__(self) -> int:
        return len(self.names)

    def __iter__(self) -> Iterator[ContactSet]:
        for name, start, end in zip(self.names, self.starts[:-1], self.starts[1:], strict=True):
            if not name:
                yield ContactSet(name, unreadable=_NO_NAME)
                continue
            picked = self.rows[start:end]
            cells = zip(*(map(_cell, column[picked].tolist()) for column in self.columns), strict=True)
            yield ContactSet(name, (self.head + "\n".join(map(",".join, cells))).encode(), lines=())


def parquet_table(path: Path) -> ParquetTable:
    """The sets of a parquet file with the columns of a contact file and a column set.

    units, tip_radius and sigma are in the metadata of its schema, if they are given. Null and nan are empty
    cells. Raises FileError for any other file, MissingExtraError without pyarrow.
    """
    try:
        import pyarrow.parquet as pq
        from pyarrow.lib import ArrowInvalid
    except ImportError:
        raise MissingExtraError("batch", "parquet") from None
    try:
        table = pq.read_table(io.BytesIO(read_bytes(path)))
    except (ArrowInvalid, OSError) as error:
        raise FileError(str(path), [Problem(f"this is no parquet file: {error}", "check how it was written")]) from None
    lowered = [str(name).strip().lower() for name in table.column_names]
    names = [name for name in lowered if name != SET]
    problems: list[Problem] = []
    settings = _settings(table.schema.metadata or {})
    head = "".join(f"# {key}: {value}\n" for key, value in settings.items()) + ",".join(names) + "\n"
    read_header(head.splitlines(), problems, feature_needed=True)
    if lowered.count(SET) != 1:
        problems.insert(0, Problem("there is no column 'set'", "add one with the name of each contact's set"))
    if not table.num_rows:
        problems.append(Problem("there are no contacts", "write one row for each touch"))
    if problems:
        # Lines of the generated text mean nothing to the user.
        raise FileError(str(path), [Problem(problem.what, problem.remedy) for problem in problems])
    found, rows, starts = _by_set(table.column(lowered.index(SET)))
    columns = tuple(_array(table.column(k)) for k, name in enumerate(lowered) if name != SET)
    return ParquetTable(head, columns, found, rows, starts)


def _settings(metadata: dict[bytes, bytes]) -> dict[str, str]:
    """units, tip_radius and sigma of the metadata, as text."""
    values = {key.decode(errors="replace"): value.decode(errors="replace") for key, value in metadata.items()}
    return {key: " ".join(values[key].split()) for key in SETTING_KEYS if key in values}


def _by_set(column: "pa.ChunkedArray") -> tuple[tuple[str, ...], Ints, Ints]:
    """Names in order of first appearance, row indices sorted by set, and the start of each set among them."""
    encoded = column.combine_chunks().dictionary_encode(null_encoding="encode")
    order = np.asarray(encoded.indices.to_numpy(zero_copy_only=False), dtype=np.intp)
    # The dictionary keeps the order of first appearance, and the sort is stable: sets and rows keep their order.
    names = tuple("" if name is None else str(name).strip() for name in encoded.dictionary.to_pylist())
    rows = np.argsort(order, kind="stable")
    return names, rows, np.searchsorted(order[rows], np.arange(len(names) + 1))


def _array(column: "pa.ChunkedArray") -> Any:
    """A column as an array of objects: numbers, texts and None."""
    return column.to_numpy(zero_copy_only=False)


def _cell(value: object) -> str:
    """A cell as CSV, quoted if necessary; a number as its shortest exact decimal."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, str):
        return (
            '"' + value.replace('"', '""') + '"' if any(mark in value for mark in ',"') else " ".join(value.split("\n"))
        )
    return repr(value)
