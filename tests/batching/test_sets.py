"""Contact sets from files, directories and tables: the same contacts as from one file for each set."""

import random
from pathlib import Path

import numpy as np
import pytest

from tactfix import Fixture, load_contacts, load_fixture
from tactfix.batching.task import ContactSet
from tactfix.contacts import Contacts
from tactfix.errors import FileError
from tactfix.files.contact_sets import find_sets
from tests.support.contact_sets import HEADER, PLAIN, contact_file, rows, write_cell


@pytest.fixture
def cell_fixture(tmp_path: Path) -> Fixture:
    return load_fixture(write_cell(tmp_path, 3)[0])


def read(fixture: Fixture, contact_set: ContactSet) -> Contacts:
    return PLAIN(fixture, contact_set)[0]


def same(one: Contacts, other: Contacts) -> bool:
    arrays = ((getattr(one, name), getattr(other, name)) for name in ("points", "approaches", "sigmas"))
    return one.features == other.features and all(np.array_equal(a, b, equal_nan=True) for a, b in arrays)


def table(separator: str = ",", names: tuple[str, ...] = ("west", "east", "north")) -> str:
    lines = [f"{name},{row}" for k, name in enumerate(names) for row in rows(k)]
    random.Random(1).shuffle(lines)  # rows of a set need not be adjacent
    text = "\n".join(["# sigma: 0.02", "Set," + HEADER, *lines]) + "\n"
    return text if separator == "," else text.replace(",", separator).replace(".", ",")


def own_files(text: str) -> dict[str, str]:
    """The table split by hand: one file for each set, with the same header."""
    head, columns, *lines = text.splitlines()
    separator = next(mark for mark in ";\t," if mark in columns)
    files: dict[str, list[str]] = {}
    for line in lines:
        name, rest = line.split(separator, 1)
        files.setdefault(name, [head, columns.split(separator, 1)[1]]).append(rest)
    return {name: "\n".join(parts) for name, parts in files.items()}


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_a_csv_table_is_many_files(tmp_path: Path, cell_fixture: Fixture, separator: str) -> None:
    text = table(separator)
    (tmp_path / "t.csv").write_text(text)
    sets = list(find_sets([str(tmp_path / "t.csv")]))
    expected = own_files(text)
    assert [one.name for one in sets] == list(expected)
    for one in sets:
        assert same(read(cell_fixture, one), load_contacts(expected[one.name].encode(), cell_fixture))


def test_the_column_set_may_be_in_any_position(tmp_path: Path, cell_fixture: Fixture) -> None:
    lines = [row.rsplit(",", 3) for row in rows(0)]
    text = "feature,x,y,z,set,ax,ay,az\n" + "\n".join(
        f'{place},"one, and only",{",".join(way)}' for place, *way in lines
    )
    (tmp_path / "t.csv").write_text(text)
    (one,) = find_sets([str(tmp_path / "t.csv")])
    assert one.name == "one, and only"
    assert same(read(cell_fixture, one), load_contacts(contact_file(0).encode(), cell_fixture))


def test_a_bad_row_is_reported_with_its_line_of_the_table(tmp_path: Path, cell_fixture: Fixture) -> None:
    lines = table().splitlines()
    bad = next(k for k, line in enumerate(lines) if line.startswith("east,b"))
    lines[bad] = lines[bad].replace("east,b,", "east,bee,")
    (tmp_path / "t.csv").write_text("\n".join(lines))
    for one in find_sets([str(tmp_path / "t.csv")]):
        if one.name != "east":
            assert len(read(cell_fixture, one)) == 15
            continue
        with pytest.raises(FileError) as caught:
            read(cell_fixture, one)
        (problem,) = caught.value.problems
        assert problem.line == bad + 1
        assert "no feature 'bee'" in problem.what


def test_rows_without_a_set_are_a_set_of_their_own(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text(f"set,{HEADER}\nn,{rows(0)[0]}\n,{rows(0)[1]}\n")
    named, nameless = find_sets([str(tmp_path / "t.csv")])
    assert named.unreadable is None
    assert nameless.unreadable is not None
    assert "line 3" in nameless.unreadable


def test_a_header_that_no_file_could_have_refuses_the_table(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("set,feature,x,y,u\na,b,1,2,3\n")
    with pytest.raises(FileError, match=r"line 1: there is no column 'z'") as caught:
        find_sets([str(tmp_path / "t.csv")])
    assert "'u'" in str(caught.value)


def test_a_setting_below_the_header_refuses_the_table(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text(f"set,{HEADER}\na,{rows(0)[0]}\n# units: m\n")
    with pytest.raises(FileError, match="line 3"):
        find_sets([str(tmp_path / "t.csv")])


def write_parquet(path: Path, text: str, **metadata: str) -> None:
    pa = pytest.importorskip("pyarrow")
    pq = pytest.importorskip("pyarrow.parquet")
    header, *lines = [line for line in text.splitlines() if not line.startswith("#")]
    cells = [line.split(",") for line in lines]
    columns = {
        name: [row[k] if k < 2 else float(row[k]) if row[k] else None for row in cells]
        for k, name in enumerate(header.split(","))
    }
    pq.write_table(pa.table(columns).replace_schema_metadata(metadata), path, row_group_size=7)


def test_a_parquet_table_is_the_same_table(tmp_path: Path, cell_fixture: Fixture) -> None:
    text = table()
    write_parquet(tmp_path / "t.parquet", text, sigma="0.02")
    (tmp_path / "t.csv").write_text(text)
    columns = list(find_sets([str(tmp_path / "t.parquet")]))
    lines = list(find_sets([str(tmp_path / "t.csv")]))
    assert [one.name for one in columns] == [one.name for one in lines]
    for one, other in zip(columns, lines, strict=True):
        assert same(read(cell_fixture, one), read(cell_fixture, other))
        assert read(cell_fixture, one).sigmas[0] == 0.02


def test_parquet_sets_may_be_numbers_and_approaches_missing(tmp_path: Path, cell_fixture: Fixture) -> None:
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    points = [list(map(float, row.split(",")[1:4])) for row in rows(0)]
    missing = [None, float("nan")] + [None] * 13
    columns = {
        "set": [7] * 10 + [None] * 5,
        "feature": [row[0] for row in rows(0)],
        **{name: [point[k] for point in points] for k, name in enumerate("xyz")},
        **dict.fromkeys(("ax", "ay", "az"), pa.array(missing, pa.float64())),
    }
    pq.write_table(pa.table(columns), tmp_path / "t.parquet")
    numbered, nameless = find_sets([str(tmp_path / "t.parquet")])
    assert numbered.name == "7"
    contacts = read(cell_fixture, numbered)
    assert np.array_equal(contacts.points, points[:10])
    assert not contacts.has_approach.any()
    assert nameless.unreadable is not None


@pytest.mark.parametrize("content", [b"", b"not parquet", b"PAR1xxxxPAR1"])
def test_invalid_parquet_files_are_rejected(tmp_path: Path, content: bytes) -> None:
    pytest.importorskip("pyarrow")
    (tmp_path / "t.parquet").write_bytes(content)
    with pytest.raises(FileError, match="no parquet file"):
        find_sets([str(tmp_path / "t.parquet")])


def test_parquet_without_sets_is_refused(tmp_path: Path) -> None:
    write_parquet(tmp_path / "t.parquet", table().replace("Set,", "Group,"))
    with pytest.raises(FileError, match="no column 'set'"):
        find_sets([str(tmp_path / "t.parquet")])


def test_a_directory_is_its_contact_files_by_name(tmp_path: Path, cell_fixture: Fixture) -> None:
    folder = tmp_path / "sets"
    (folder / ".hidden.csv").write_text("x")
    (folder / "notes.md").write_text("x")
    (folder / "results.csv").write_text("x")
    (folder / "001.csv").unlink()
    (folder / "deeper").mkdir()
    names = [Path(one.name).name for one in find_sets([str(folder)], leave_out=folder / "results.csv")]
    assert names == ["000.csv", "002.csv"]
    with pytest.raises(FileError, match="no contact files"):
        find_sets([str(folder / "deeper")])


def test_sources_keep_their_order_and_missing_files_are_reported(tmp_path: Path, cell_fixture: Fixture) -> None:
    (tmp_path / "t.csv").write_text(table())
    sources = [str(tmp_path / "sets" / "002.csv"), "no-such.csv", str(tmp_path / "t.csv"), str(tmp_path / "sets")]
    found = find_sets(sources)
    sets = list(found)
    assert len(found) == len(sets) == 1 + 1 + 3 + 3
    assert [one.name for one in sets[:2]] == sources[:2]
    assert sets[1].unreadable is not None
    assert "no such file" in sets[1].unreadable
