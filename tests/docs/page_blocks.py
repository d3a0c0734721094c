# SPDX-License-Identifier: LGPL-2.1-or-later
"""The fenced blocks of a page, and what comments above them ask for.

Comments, which no reader sees, stand on lines of their own above a block:
    <!-- not run: REASON -->       the block is only read; the test lists it
    <!-- part of SCENE -->         an xml fragment: its components replace, or join, those of SCENE, and that is checked
    <!-- refused: WORDS -->        an xml scene or fragment that `stroma check` must refuse, with these words
    <!-- exit code N -->           the last command of an sh block ends with N
    <!-- times vary -->            of an output: numbers before a unit of time, rate or memory are not compared
    <!-- not output -->            a text block that is no output of the commands before it
    <!-- formula -->               a text block with a formula, a figure or a list

Every block names its language: what has none would be looked at by no test."""
import re
from dataclasses import dataclass, field

OPEN = re.compile(r"^(\s*)(```+|~~~+)\s*([\w+-]*)\s*(.*)$")
COMMENT = re.compile(r"^\s*<!--\s*(not run|part of|refused|exit code|times vary|not output|formula)\s*:?\s*(.*?)\s*-->\s*$")
TITLE = re.compile(r'title="([^"]+)"')


class PageError(Exception):
    """A page that does not keep to the rules."""


@dataclass
class Block:
    """One fenced block."""
    line: int
    language: str
    title: str
    text: str
    asked: dict = field(default_factory=dict)


def blocks_of(text):
    """All fenced blocks of a page, in order."""
    found, asked, lines, number = [], {}, text.split("\n"), 0
    while number < len(lines):
        line = lines[number]
        comment, opening = COMMENT.match(line), OPEN.match(line)
        if comment:
            asked[comment.group(1)] = comment.group(2)
        elif opening:
            number, block = _read(lines, number, opening, asked)
            found.append(block)
            asked = {}
        elif line.strip():
            if asked:
                raise PageError(f"line {number}: '{next(iter(asked))}' stands above no block")
        number += 1
    return found


def _read(lines, start, opening, asked):
    indent, fence, language, rest = opening.groups()
    body, number = [], start + 1
    while number < len(lines) and lines[number].strip() != fence:
        body.append(lines[number][len(indent):] if lines[number].startswith(indent) else lines[number])
        number += 1
    if number == len(lines):
        raise PageError(f"line {start + 1}: the block has no end")
    if asked.get("not run") == "":
        raise PageError(f"line {start + 1}: 'not run' without a reason")
    if not language:
        raise PageError(f"line {start + 1}: a block without a language (text, after <!-- formula --> or <!-- not output -->, if it is none)")
    title = TITLE.search(rest)
    return number, Block(start + 1, language.lower(), title.group(1) if title else "", "\n".join(body) + "\n", asked)


# ---- outputs ----

NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d[\d,]*\.?\d*|\.\d+)(?:e[-+]?\d+)?(?![\w.]*\w)", re.I)
VARYING = re.compile(r"\s*(?:ns|us|µs|ms|s|min|h|steps/s|steps per second|ms per step|ms/step|kB|MB|GB)(?![\w/])")


def _numbers(line, times_vary):
    """The line with # for numbers, and the numbers that count with the size of their last digit."""
    found = []

    def take(match):
        if not (times_vary and VARYING.match(line, match.end())):
            text = match.group(0).replace(",", "")
            mantissa, _, exponent = text.lower().partition("e")
            digits = len(mantissa.partition(".")[2])
            found.append((float(text), 10.0 ** (int(exponent or 0) - digits)))
        else:
            found.append(None)
        return "#"

    return re.sub(r"\s+", " ", NUMBER.sub(take, line)).strip(), found


def _same(expected, real, times_vary, tolerance=0.01):
    shape, numbers = _numbers(expected, times_vary)
    real_shape, real_numbers = _numbers(real, times_vary)
    if "..." in shape:  # anything may stand there; numbers are then compared up to it
        head = shape.split("...")[0]
        pattern = ".*".join(re.escape(part) for part in shape.split("..."))
        numbers, real_numbers = numbers[:head.count("#")], real_numbers[:head.count("#")]
        if not re.fullmatch(pattern, real_shape):
            return False
    elif shape != real_shape:
        return False
    for one, other in zip(numbers, real_numbers):
        if one and other and abs(one[0] - other[0]) > max(tolerance * abs(one[0]), 1.01 * one[1]):
            return False
    return True


def missing_output(expected, real, times_vary):
    """The first line of `expected` that `real` does not have, in this order; None when all are there."""
    lines = iter(real.split("\n"))
    for line in expected.split("\n"):
        if line.strip() in ("", "..."):
            continue
        if not any(_same(line, other, times_vary) for other in lines):
            return line
    return None
