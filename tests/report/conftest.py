"""Contacts on the plate of the robot cell, as a file."""

import pytest

from tactfix.cli.app import run
from tests.support.project import PLATE_FILE


@pytest.fixture(scope="package")
def contacts_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("contacts") / "contacts.csv"
    assert run(["simulate", str(PLATE_FILE), "--seed", "3", "--output", str(path)]) == 0
    return path
