"""The rows of a contact file below its header, cut into columns."""

from collections.abc import Sequence

from tactfix.errors import Problem
from tactfix.files.contact_header import Header, key_of
from tactfix.files.contact_table import Table


def read_table(lines: Sequence[str], header: Header, problems: list[Problem]) -> Table | None:
    """The cells below the header; None, with a problem, where there are none or where rows differ in length."""
    body, places = _content(lines, header, problems)
    if not body:
        problems.append(Problem("there are no contacts", "write one row for each touch below the header row"))
        return None
    text = "\n".join(body)
    width = len(header.columns)
    rows_of_cells = None
    if '"' in text:
        rows_of_cells = _quoted_rows(body, places, header, problems)
        if rows_of_cells is None:
            return None
        widths = list(map(len, rows_of_cells))
    else:
        widths = [line.count(header.separator) + 1 for line in body]
    if set(widths) != {width}:
        problems.extend(_ragged(widths, places, header))
        return None
    # Cells of all rows in one list: a list for each row would cost more than all numbers together.
    cells = (
        text.replace("\n", header.separator).split(header.separator)
        if rows_of_cells is None
        else [cell for row in rows_of_cells for cell in row]
    )
    if " " in text or "\t" in text:
        cells = [cell.strip() for cell in cells]
    return Table({name: cells[k::width] for k, name in enumerate(header.columns)}, places, header.separator)


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
) -> list[list[str]] | None:
    """The rows of a file with quotation marks; None, with a problem, where one is left open."""
    import csv

    try:
        rows = list(csv.reader(body, delimiter=header.separator, strict=True))
    except csv.Error:
        rows = []
    if len(rows) == len(body):
        return rows
    # The first line that cannot be read by itself.
    for index, line in enumerate(body):
        try:
            next(csv.reader([line], delimiter=header.separator, strict=True))
        except csv.Error:
            what, remedy = "a quotation mark is left open or stands inside a cell", "close it in its line, or remove it"
            problems.append(Problem(what, remedy, line=places[index], row=index + 1))
            break
    return None


def _ragged(widths: Sequence[int], places: Sequence[int], header: Header) -> list[Problem]:
    """A problem for each row with more or fewer cells than the header."""
    width = len(header.columns)
    fewer = f"write {header.separator.join(header.columns)}; leave a cell empty, but keep its separator"
    more = f"{fewer}; decimal commas need semicolons or tabs between cells" if header.separator == "," else fewer
    return [
        Problem(
            f"{found} cells where the header has {width}",
            more if found > width else fewer,
            line=places[index],
            row=index + 1,
        )
        for index, found in enumerate(widths)
        if found != width
    ]
