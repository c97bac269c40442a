"""A quick look at corrected contacts, before they are located again."""

import numpy as np

from tactfix.contacts import Contacts
from tactfix.diagnosis.feasibility import are_beyond_boxes, least_chi_square
from tactfix.errors import TactfixError
from tactfix.fixture import Fixture
from tactfix.noise import SURE, chi_square_limit
from tactfix.probe import residual_sigmas
from tactfix.relations.realization import fixture_scale, realize


class Screen:
    """Rules out at little cost what no pose explains, whatever the shape that the relations leave the fixture."""

    def __init__(self, fixture: Fixture, rows: frozenset[int]) -> None:
        self.fixture, self.rows = fixture, rows
        self.shapes = realize(fixture)
        scale = fixture_scale(fixture)
        slack = [r.sigma * (1.0 if r.kind == "distance" else scale) for r in fixture.relations]
        self.slack = SURE * float(np.linalg.norm(slack))

    def lets_pass(self, contacts: Contacts) -> bool:
        """Whether the contacts of these rows do not rule every pose out."""
        asked = contacts.subset([i for i, row in enumerate(contacts.rows) if row in self.rows])
        sigmas = np.hypot(residual_sigmas(self.fixture, asked), self.slack)
        limit = chi_square_limit(self.fixture.dof(contacts.features))
        try:
            return not self.shapes or any(
                least_chi_square(shape, asked, sigmas) <= limit
                and not are_beyond_boxes(shape, self.fixture.touch, asked)
                for shape in self.shapes
            )
        except TactfixError:  # a tip that does not fit into a bore
            return False
