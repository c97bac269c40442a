"""Which format the text of a pose is in, where it holds marks that no other format has; never a guess.

Numbers alone are a matrix or nothing: six of them mean another turn for every maker.
"""

import re
from typing import Final

_ROUGH_NUMBER: Final = r"\s{0,20}[-+.0-9eE]{1,40}\s{0,20}"
_MARKS: Final = tuple(
    (name, re.compile(pattern, re.IGNORECASE | re.MULTILINE))
    for name, pattern in (
        ("kuka", r"\{\s*(?:(?:E6POS|POS|FRAME)\s*:\s*)?[XYZABC]\s+[-+.0-9]"),
        ("abb-wobjdata", r"\[\s*(?:TRUE|FALSE)\s*,\s*(?:TRUE|FALSE)\s*,"),
        (
            "abb",
            rf"\[\s*\[{_ROUGH_NUMBER},{_ROUGH_NUMBER},{_ROUGH_NUMBER}\]\s*,\s*\[{_ROUGH_NUMBER},{_ROUGH_NUMBER},{_ROUGH_NUMBER},{_ROUGH_NUMBER}\]",
        ),
        (
            "fanuc",
            r"(?<!\w)X\s*[=:]\s*[-+.0-9][^{}]{0,120}(?<!\w)W\s*[=:][^{}]{0,120}(?<!\w)P\s*[=:][^{}]{0,120}(?<!\w)R\s*[=:]",
        ),
        ("ur", rf"(?<!\w)p\s*\[{_ROUGH_NUMBER},"),
        ("kawasaki", r"(?<!\w)TRANS\s*\("),
        ("comau", r"(?<!\w)POS\s*\("),
        ("doosan", r"(?<!\w)posx\s*\("),
        ("mecademic", r"(?<!\w)SetWrf\s*\("),
        ("siemens", r"(?<!\w)CTRANS\s*\("),
        ("heidenhain", r"PLANE\s+SPATIAL"),
        ("g68.2", r"G\s*0*68\.2(?![0-9])"),
        ("g10", r"G\s*0*10\s*L\s*0*20?(?![0-9.])"),
        ("ros-static", r"static_transform_publisher"),
        ("urdf", r"<origin\s"),
        ("ros", r"^[ \t-]*(?:translation|position|transformation|Rotation: in Quaternion[^\[]*)\s*:?[ \t]*(?:$|[\[{])"),
        ("yaml", r"^[ \t]*schema[ \t]*:\s*['\"]?tactfix/"),
    )
)
_LINE_BREAK: Final = re.compile(r"\r\n?|\n")
_POSE_WITHIN: Final = 1 << 16
"""A pose is told within so many characters, whatever program it stands in."""


def recognized(text: str) -> str | None:
    """The one format whose marks the text holds; None for none of them, and where there are those of several."""
    spoken = _LINE_BREAK.sub("\n", text[:_POSE_WITHIN])
    found = [name for name, mark in _MARKS if mark.search(spoken)]
    # What a work object holds within are poses of ABB.
    found = [name for name in found if name != "abb"] if "abb-wobjdata" in found else found
    return found[0] if len(found) == 1 else None
