"""The theory behind each finding, in about ten lines: what `design-check --explain CODE` prints."""

from tactfix.coded_texts import text_of, texts_of


def explanation(code: str) -> str:
    """The explanation of a finding's code. Raises UsageError for an unknown one."""
    return text_of("tactfix.design", code, "finding")


def explanations() -> dict[str, str]:
    """All explanations by code."""
    return texts_of("tactfix.design")
