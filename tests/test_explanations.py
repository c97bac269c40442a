"""Every status, reason and diagnosis is explained, on the command line and by name in the shell."""

from typing import get_args

import pytest

from tactfix.cli.completion import verdict_codes
from tactfix.explanations import explanations
from tactfix.mistakes import CAUSES
from tactfix.results import ReasonCode, Status
from tests.support.command_line import tactfix

CODES = {*get_args(Status), *get_args(ReasonCode), *CAUSES}


def test_every_code_has_a_text_and_every_text_a_code():
    assert set(explanations("localization")) == CODES
    for code, text in explanations("localization").items():
        lines = text.splitlines()
        assert 3 <= len(lines) <= 12, code
        assert max(map(len, lines)) <= 79, code


@pytest.mark.parametrize("code", ["ambiguous", "prior", "tip_offset"])
def test_the_command_prints_it_and_needs_no_files(code):
    done = tactfix("locate", "--explain", code)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == f"{code}\n\n{explanations('localization')[code]}\n"


def test_an_unknown_code_is_refused_with_the_nearest():
    done = tactfix("locate", "--explain", "tip_ofset")
    assert (done.returncode, done.stdout) == (2, "")
    assert "did you mean 'tip_offset'?" in done.stderr


def test_the_shell_offers_the_codes():
    assert set(verdict_codes("")) == CODES
    assert verdict_codes("tip") == ["tip", "tip_radius", "tip_offset"]
