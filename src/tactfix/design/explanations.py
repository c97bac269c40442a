"""The theory behind each finding, in about ten lines: what `design-check --explain CODE` prints."""

from functools import cache
from importlib import resources

from tactfix.errors import UsageError
from tactfix.wording import did_you_mean


def explanation(code: str) -> str:
    """The explanation of a finding's code. Raises UsageError for an unknown one."""
    texts = explanations()
    if code not in texts:
        raise UsageError(f"no finding is called {code!r}; {did_you_mean(code, texts)}")
    return f"{code}\n\n{texts[code]}\n"


@cache
def explanations() -> dict[str, str]:
    """All explanations by code, from explanations.txt: a line [code], then its text."""
    text = resources.files("tactfix.design").joinpath("explanations.txt").read_text(encoding="utf-8")
    parts = (part.partition("]\n") for part in text.split("\n[")[1:])
    return {code: body.strip() for code, _, body in parts}
