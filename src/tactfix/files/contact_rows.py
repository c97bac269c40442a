"""The rows of a contact file below its header, cut into columns."""

from collections.abc import Iterator, Sequence

from tactfix.errors import Problem
from tactfix.files.contact_header import Header
from tactfix.files.contact_settings import key_of
from tactfix.files.contact_table import Table
from tactfix.wording import UNPRINTABLE


def read_table(lines: Sequence[str], header: Header, problems: list[Problem]) -> Table | None:
    """The cells below the header; None, with a problem, where there are none.

    A row that cannot be cut into the columns of the header is a problem and left out: the others are judged all the
    same, under the numbers that they have in the file.
    """
    body, places = _content(lines, header, problems)
    if not body:
        problems.append(Problem("there are no contacts", "write one row for each touch below the header row"))
        return None
    text = "\n".join(body)
    problems.extend(_unprintable(text, body, places))
    width = len(header.columns)
    rows: Sequence[int] = range(1, len(body) + 1)
    if '"' in text:
        cut = _quoted_rows(body, places, header, problems)
        sound = [index for index, cells in enumerate(cut) if cells is not None and len(cells) == width]
        widths = [width if cells is None else len(cells) for cells in cut]
        cells = [cell for index in sound for cell in cut[index] or ()]
    else:
        widths = [line.count(header.separator) + 1 for line in body]
        sound = [index for index, found in enumerate(widths) if found == width]
        # Cells of all rows in one list: a list for each row would cost more than all numbers together.
        whole = text if len(sound) == len(body) else "\n".join(body[index] for index in sound)
        cells = whole.replace("\n", header.separator).split(header.separator) if sound else []
    problems.extend(_ragged(body, widths, places, header))
    if len(sound) < len(body):
        rows, places = [rows[index] for index in sound], [places[index] for index in sound]
    if " " in text or "\t" in text:
        cells = [cell.strip() for cell in cells]
    columns: dict[str, Sequence[str]] = {name: cells[k::width] for k, name in enumerate(header.columns)}
    for name in ("feature", "id"):
        if name in columns and "'" in text:
            columns[name] = [_without_apostrophe(cell) for cell in columns[name]]
    return Table(columns, rows, places, header.separator)


def _without_apostrophe(cell: str) -> str:
    """A text without the apostrophe that keeps a spreadsheet from taking it for a formula."""
    return cell[1:] if cell.startswith(("'=", "'+", "'-", "'@")) else cell


def _unprintable(text: str, body: Sequence[str], places: Sequence[int]) -> Iterator[Problem]:
    """A problem for each row with a character that a terminal or a comment would obey."""
    if not UNPRINTABLE.search(text):
        return
    for index, line in enumerate(body):
        found = UNPRINTABLE.search(line)
        if found:
            what, remedy = f"there is a control character, {found[0]!r}", "remove it; it may not show in your editor"
            yield Problem(what, remedy, line=places[index], column=found.start() + 1, row=index + 1)


def _content(lines: Sequence[str], header: Header, problems: list[Problem]) -> tuple[list[str], Sequence[int]]:
    """The rows that hold something, and the line of each; comments are passed over, settings among them are not."""
    rest = lines[header.first_line :]
    first = header.first_line + 1
    empty = header.separator + " \t"
    keep = [bool(line.strip(empty)) and not line.lstrip().startswith("#") for line in rest]
    for number, line in enumerate(rest, first):
        if "#" in line and line.lstrip().startswith("#"):
            key = key_of(line.strip())
            if key:
                problems.append(Problem(f"{key} stands below the header row", "move it above", line=number))
    if all(keep):
        return list(rest), range(first, first + len(rest))
    body = [line for line, kept in zip(rest, keep, strict=True) if kept]
    return body, [number for number, kept in enumerate(keep, first) if kept]


def _quoted_rows(
    body: list[str], places: Sequence[int], header: Header, problems: list[Problem]
) -> list[list[str] | None]:
    """The cells of each row of a file with quotation marks; None, with a problem, where one is left open."""
    import csv

    rows: list[list[str] | None] = []
    for index, line in enumerate(body):
        try:
            rows.append(next(csv.reader([line], delimiter=header.separator, strict=True)))
        except csv.Error:
            what, remedy = "a quotation mark is left open or stands inside a cell", "close it in its line, or remove it"
            problems.append(Problem(what, remedy, line=places[index], row=index + 1))
            rows.append(None)
    return rows


def _ragged(body: Sequence[str], widths: Sequence[int], places: Sequence[int], header: Header) -> list[Problem]:
    """A problem for each row with more or fewer cells than the header."""
    width, mark = len(header.columns), header.separator
    fewer = f"write {mark.join(header.columns)}; leave a cell empty, but keep its separator"
    more = f"{fewer}; decimal commas need semicolons or tabs between cells" if mark == "," else fewer
    closed = "remove the separator at the end of the row"

    def remedy(index: int) -> str:
        if widths[index] < width:
            return fewer
        return closed if body[index].rstrip(" ").endswith(mark) else more

    return [
        Problem(f"{found} cells where the header has {width}", remedy(index), line=places[index], row=index + 1)
        for index, found in enumerate(widths)
        if found != width
    ]
