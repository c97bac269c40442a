"""Settings of all tests: one thread of linear algebra, and the longest tests first."""

import os

import pytest

# pytest -n keeps the cores busy, so BLAS threads would mostly wait for each other. Set before numpy is imported.
for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

LONGEST = ("tests/test_architecture.py::test_the_tool_finds_nothing[mypy]",)
"""The longest tests; started last, they would leave all processes but one idle."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: item.nodeid not in LONGEST)
