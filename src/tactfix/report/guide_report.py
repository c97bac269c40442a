"""A step of guidance as one line for people, or as one line of JSON."""

import json
from typing import Final

from tactfix.acceptance import sigma_at
from tactfix.monitoring.guide import GuideStep
from tactfix.report.json_report import Json, locate_json, number

GUIDE_SCHEMA: Final = "tactfix/guide/1"
_OF_LOCATE: Final = (
    *("tactfix_version", "fixture", "units", "status", "transform", "covariance", "rms"),
    *("free_motions", "next_contact", "diagnosis", "warnings"),
)


def guide_line(step: GuideStep) -> str:
    """Touches, what is open, what to do."""
    touches = "1 touch" if step.touches == 1 else f"{step.touches} touches"
    return f"{touches}: {step.state}; {step.advice}"


def guide_json(step: GuideStep) -> Json:
    """What is known after so many touches."""
    located = locate_json(step.result)
    return {
        "schema": GUIDE_SCHEMA,
        "touches": step.touches,
        "done": step.is_done,
        **{name: located[name] for name in _OF_LOCATE},
        "sigma": number(sigma_at(step.result)),
        "exceeded": list(step.exceeded),
        "state": step.state,
        "advice": step.advice,
    }


def guide_json_line(step: GuideStep) -> str:
    """The same in one line."""
    return json.dumps(guide_json(step), allow_nan=False) + "\n"
