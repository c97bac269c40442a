# ruff: noqa: E501 - the lines of machines are as long as they are
"""One character of a line changed, lost or added: the contact that the text states, or the line is rejected.

An independent reader decides what the text states: a pattern made from the original line, in which only the numbers
and the amount of white space may vary.
"""

import random
import re
import string

import numpy as np
import pytest

from tactfix.errors import FileError, UsageError
from tactfix.files.contact_options import ContactOptions, log_options
from tactfix.files.logs import LOG_FORMATS
from tactfix.files.logs.load import read_log
from tests.support.machine_logs import GOOD

NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
ALPHABET = string.printable.replace("\n", "").replace("\r", "").replace("\x0b", "").replace("\x0c", "") + "é٣−"
# Preceding lines, the line itself with its numbers between backquotes, following lines; the indices of x, y, z.
LINES = {
    "linuxcnc": ("", "`604.172085` `-57.541648` `238.076106` `0.000000` `0.000000` `0.000000` `0.000000` `0.000000` `0.000000`", ""),
    "grbl": ("", "[PRB:`-190.000`,`-90.000`,`-49.000`:1]", "\nok"),
    "msr": ("G800 N1 X0 Y0 Z0 I0 J0 K1\n", "G801 N1 X`42.9984` Y`14.9986` Z`-30.4519` R`0.9956`", ""),
    "xyzijk": ("XYZIJK METRIC\n", "`42.9984`,`14.9986`,`30.4519`,`0.000000`,`-1.000000`,`0.000000`", ""),
    "xyz": ("", "`42.9984` `14.9986` `-30.4519`", ""),
    "ippdme": ("", "00169 # X(`-4.30052E001`), Y(`1.49967E001`), Z(`3.04056E001`), IJK(`0`, `0`, `1`), Tool.A(`0`), R(`90.0`), ER(`9.95606E-001`)", ""),
    "dmis": ("UNITS/MM,ANGDEC\n", "PTMEAS/CART,`42.9984`,`14.9986`,`30.4519`,`0`,`0`,`1`", "\nENDMES"),
    "ur": ("", "p[`0.4255`, `-0.2025`, `0.3000`, `0.1`, `3.0`, `-0.2`]", ""),
    "kuka": ("", "DECL E6POS XP1={X `1025.5`,Y `-20.25`,Z `300.0`,A `10.0`,B `90.0`,C `0.0`,S 2,T 35,E1 `0.0`,E2 `0.0`}", ""),
    "abb": ("", "CONST robtarget p10:=[[`1025.5`,`-20.25`,`300`],[`1`,`0`,`0`,`0`],[`0`,`-1`,`0`,`1`],[`9E+09`,`9E+09`,`9E+09`,`9E+09`,`9E+09`,`9E+09`]];", ""),
    "fanuc": ("P[1]{\n GP1:\n UF : 0, UT : 1, CONFIG : 'N U T, 0, 0, 0',\n", "\tX =   `856.686`  mm,\tY =   `-197.400`  mm,\tZ =  `172.511`  mm,\n\tW =  `-126.1` deg,\tP =  `87.9` deg,\tR =  `.5` deg", "\n};\n"),
}  # fmt: skip
OTHERS = {
    "grbl console": ("grbl", "[22:44:42] [ G38.2 Z-20 F80 ] [PRB:`-190.000`,`-90.000`,`-49.000`:1]"),
    "grbl of four axes": ("grbl", "[PRB:`-190.000`,`-90.000`,`-49.000`,`12.500`:1]"),
    "TinyG": ("grbl", '{"r":{"prb":{"e":1,"x":`-190.000`,"y":`-90.000`,"z":`-49.000`}},"f":[1,0,0,1428]}'),
    "kuka columns": ("kuka", "`1025,5`;`-20,25`;`300,0`;`10,0`;`90,0`;`0,0`"),
    "kuka bare": ("kuka", "{X `1025.5`,Y `-20.25`,Z `300.0`,A `10.0`,B `90.0`,C `0.0`}"),
    "ur columns": ("ur", "`0.4255`,`-0.2025`,`0.3000`,`0.1`,`3.0`,`-0.2`"),
    "abb pose": ("abb", "[[`1025.5`,`-20.25`,`300`],[`1`,`0`,`0`,`0`]]"),
    "fanuc columns": ("fanuc", "`856.686` `-197.400` `172.511` `-126.1` `87.9` `.5`"),
    "xyz with normal": ("xyz", "P1\t`42.9984`\t`14.9986`\t`30.4519`\t`0.6`\t`-0.8`\t`0.0`"),
    "ippdme in PtMeas": ("ippdme", "00169 # PtMeas(X(`-4.3`), Y(`14.5`), Z(`30.5`), IJK(`0`, `0`, `1`), ER(`0.99`))"),
}  # fmt: skip
CASES = {name: (name, *parts) for name, parts in LINES.items()}
CASES |= {case: (name, "", line, "") for case, (name, line) in OTHERS.items()}


def template(line):
    """A pattern of the line: numbers are groups, white space matches white space, all else is literal."""
    parts = line.split("`")
    pieces = []
    for i, part in enumerate(parts):
        if i % 2:
            pieces.append("(" + (NUMBER.replace(r"\.", "[.,]") if "," in part else NUMBER) + ")")
        else:
            words = [
                re.escape(word) for word in re.findall(r"[A-Za-z0-9_.]+|[^\sA-Za-z0-9_.]|\s+", part) if word.strip()
            ]
            pieces.append(r"\s*" + r"\s*".join(words) + r"\s*")
    return re.compile("".join(pieces), re.IGNORECASE | re.ASCII)


def damaged(line, rng):
    at = rng.randrange(len(line) + 1)
    kind = rng.choice(("change", "lose", "add"))
    if kind == "add":
        return line[:at] + rng.choice(ALPHABET) + line[at:]
    at = min(at, len(line) - 1)
    return line[:at] + ("" if kind == "lose" else rng.choice(ALPHABET)) + line[at + 1 :]


def points(name, text):
    problems = []
    log = LOG_FORMATS[name].read(text, problems)
    return [] if problems else [contact.point for contact in log.contacts]


def check(case, changes, seed):
    name, before, marked, after = CASES[case]
    line, pattern, rng = marked.replace("`", ""), template(marked), random.Random(seed)
    (whole,) = points(name, before + line + after)
    refused = 0
    for _ in range(changes):
        changed = damaged(line, rng)
        found = points(name, before + changed + after)
        refused += not found
        if not found or found == [whole]:
            continue
        match = pattern.fullmatch(changed)
        assert match is not None, f"{changed!r} is read as {found}"
        truth = [float(number.replace(",", ".")) for number in match.groups()[:3]]
        np.testing.assert_array_equal(found, [truth], err_msg=repr(changed))
    assert changes / 10 < refused < changes


@pytest.mark.parametrize("case", CASES)
def test_a_damaged_line_is_rejected_or_read_as_its_text_states(case):
    check(case, 400, seed=1)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_ten_thousand_damages_of_each_line(case):
    check(case, 10_000, seed=2)


def mutated(text, rng):
    """A log with lines lost, doubled or exchanged, characters damaged, or numbers out of range."""
    lines = text.split("\n")
    for _ in range(rng.randrange(1, 5)):
        at, other = rng.randrange(len(lines)), rng.randrange(len(lines))
        kind = rng.randrange(6)
        if kind == 0:
            lines[at], lines[other] = lines[other], lines[at]
        elif kind == 1:
            lines.insert(at, lines[other])
        elif kind == 2:
            lines[at] = re.sub(
                NUMBER, rng.choice(("1e400", "9" * 400, "1_0", "nan", "-0", "٣", "1e31", "")), lines[at], count=1
            )
        elif kind == 3:
            lines[at] = lines[at][: rng.randrange(len(lines[at]) + 1)]
        else:
            lines[at] = damaged(lines[at], rng) if lines[at] else "\x00"
    return "\n".join(lines)


def fuzz(n, seed):
    rng = random.Random(seed)
    texts = [(name, text if isinstance(text, str) else text.decode("latin-1")) for name, text in GOOD.values()]
    texts += [(name, before + line.replace("`", "") + after) for name, before, line, after in CASES.values()]
    read = 0
    for _ in range(n):
        name, text = rng.choice(texts)
        content = mutated(text, rng).encode("latin-1" if rng.random() < 0.1 else "utf-8", errors="replace")
        for count in (1, 2):
            try:
                log = read_log(
                    name, content, None, ContactOptions(units="mm"), log_options(f"a:{count}"), complete=False
                )
            except (FileError, UsageError):
                continue
            assert np.abs(log.points).max() <= 1e30
            read += 1
    return read


def test_a_fuzzed_log_is_read_or_refused():
    assert fuzz(300, 3) > 20


@pytest.mark.slow
def test_five_thousand_fuzzed_logs():
    assert fuzz(5000, 4) > 500
