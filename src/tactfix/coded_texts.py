"""Texts that stand behind codes: in a file beside a package's modules, a line [code] and then its text."""

from functools import cache
from importlib import resources

from tactfix.errors import UsageError
from tactfix.wording import did_you_mean


@cache
def texts_of(package: str) -> dict[str, str]:
    """All texts by code, from explanations.txt in a package."""
    text = resources.files(package).joinpath("explanations.txt").read_text(encoding="utf-8")
    parts = (part.partition("]\n") for part in text.split("\n[")[1:])
    return {code: body.strip() for code, _, body in parts}


def text_of(package: str, code: str, what: str) -> str:
    """The code and its text. Raises UsageError for an unknown one; what: what the codes are of."""
    texts = texts_of(package)
    if code not in texts:
        raise UsageError(f"no {what} is called {code!r}; {did_you_mean(code, texts)}")
    return f"{code}\n\n{texts[code]}\n"
