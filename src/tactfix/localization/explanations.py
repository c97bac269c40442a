"""What stands behind each status, reason and diagnosis: what `locate --explain CODE` prints."""

from tactfix.coded_texts import text_of, texts_of


def explanation(code: str) -> str:
    """The explanation of a code. Raises UsageError for an unknown one."""
    return text_of("tactfix.localization", code, "status, reason or diagnosis")


def explanations() -> dict[str, str]:
    """All explanations by code."""
    return texts_of("tactfix.localization")
