"""Wording that messages share: names in a list, and the nearest of the known names to a wrong one."""

from collections.abc import Iterable, Sequence


def did_you_mean(wrong: str, known: Iterable[str]) -> str:
    """The advice "did you mean 'ball'?" where a name is near, else "use one of: ball, bar"."""
    # difflib is imported where something has gone wrong, so that a good file does not pay for it.
    from difflib import get_close_matches

    names = list(known)
    if not names:
        return "there is none to choose from"
    by_lower = {name.lower(): name for name in reversed(names)}
    near = get_close_matches(wrong.strip().lower(), by_lower, n=1, cutoff=0.6)
    return f"did you mean {by_lower[near[0]]!r}?" if near else f"use one of: {', '.join(names)}"


def listed(names: Sequence[str]) -> str:
    """Names as a sentence lists them: a, b and c."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
