#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Holds the English of the project. In README.md, CHANGELOG.md and docs/: no sentence above 35 words, and no link to a file that
is not there. There and in comments, help texts and messages: no "one a cell" for "one per cell". In C++: no line above 140
columns, which .clang-format leaves alone in comments, and no example whose elements a formatter ran together.

Usage: check_text.py TREE, or check_text.py --self-test (plants mistakes and expects each to be found)."""
import os
import re

from planted import run, tree_files

LONGEST = 35  # words in a sentence

COUNTED = r"""(?:one|two|three|four|five|six|eight|ten|twelve|times|once|twice|\d[\d.,]*|[nmu]s|µs|ms|MB|GB|bytes|flops|flop|operations
|microseconds|milliseconds|nanoseconds|seconds|iterations?|evaluations?|factorisations?|products?|solves|linear\s+solve|doubles|values?|numbers?
|blocks?|jobs?|points?|forces?|mass|masses|directions?|matrices|matrix|rows?|lanes?|entries|terms?|fibres?|labels?|tetrahedra|hexahedra)"""
EACH = r"""(?:step|iteration|evaluation|node|tet|tetrahedron|hexahedron|triangle|edge|face|spring|cell|element|point|core|side|register
|thread|material|label|region|row|lane|pack|batch|axis|second|system|integrator|corner|vertex|instruction|cycle)"""
IDIOM = re.compile(rf"\b{COUNTED}[`)]?\s+an?\s+{EACH}\b(?![-'’])".replace("\n", ""), re.I)
# What a run said, in a table of results: quoted, not written.
SAID = re.compile(r"\bstep \d+ \(from t = |in \d+ of \d+ steps \(worst relative residual|\bnot at rest: ")
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
ABBREVIATION = re.compile(r"\b(?:St|Fig|Figs|vs|cf|al|i\.e|e\.g|resp|no|approx|etc|[A-Z])\.$")
LONGEST_LINE = 140  # columns of C++; .clang-format wraps code at 120 and does not wrap comments
RUN_TOGETHER = re.compile(r"^//+ [^<]*/> <[A-Z]", re.M)  # the end of an element of the line before, then another one
SKIPPED_FOLDERS = {"references", "meshes"}


def is_page(path):
    return path.endswith(".md") and (path.startswith("docs/") or "/" not in path)


def prose(text):
    """Pieces of running text with the line each starts on: paragraphs, list items, cells of tables. Code is left out."""
    text = re.sub(r"<!--.*?-->", lambda match: "\n" * match.group(0).count("\n"), text, flags=re.S)
    piece, start, in_code = [], 1, False
    for number, line in enumerate(text.split("\n"), 1):
        stripped = line.strip()
        fence = stripped.startswith("```")
        item = re.match(r"(?:[-*]|\d+\.)\s+", stripped)
        if fence or in_code or not stripped or stripped.startswith(("|", "#", ">")) or item:
            if piece:
                yield start, " ".join(piece)
            piece = []
        if fence:
            in_code = not in_code
        elif in_code or not stripped:
            continue
        elif stripped.startswith("|"):
            for cell in re.split(r"(?<!\\)\|", re.sub(r"`[^`]*`", "CODE", stripped)):
                yield number, cell.strip()
        elif not stripped.startswith("#"):
            if not piece:
                start = number
            piece.append(stripped[item.end():] if item else stripped)
    if piece:
        yield start, " ".join(piece)


def sentences(piece):
    """The sentences of a piece. What is in backquotes or quotation marks is one word, and so is the target of a link."""
    piece = re.sub(r"`[^`]*`|\"[^\"]*\"", "CODE", LINK.sub(lambda match: match.group(0)[1:match.group(0).index("]")], piece))
    words, found = [], []
    for word in piece.split():
        words.append(word)
        if re.search(r"[.!?][)*\"']*$", word) and not ABBREVIATION.search(word.strip("*(\"'")):
            found.append(words)
            words = []
    return found + [words] if words else found


def length(words):
    return sum(bool(re.search(r"[A-Za-z0-9]", word)) for word in words)


def problems_of_page(path, text, exists):
    for line, piece in prose(text):
        if SAID.search(piece):
            continue
        for words in sentences(piece):
            if length(words) > LONGEST:
                yield line, f"a sentence of {length(words)} words (at most {LONGEST}): {' '.join(words[:8])} ..."
    for match in LINK.finditer(text):
        target = match.group(1).split("#")[0]
        if target and "://" not in target and not exists(os.path.normpath(os.path.join(os.path.dirname(path), target))):
            yield text.count("\n", 0, match.start()) + 1, f"a link to {target}, which is not there"


def idioms(text):
    for match in IDIOM.finditer(text):
        yield text.count("\n", 0, match.start()) + 1, f'"{" ".join(match.group(0).split())}": write "per"'


def broken_lines(text):
    for number, line in enumerate(text.split("\n"), 1):
        if len(line) > LONGEST_LINE:
            yield number, f"a line of {len(line)} columns: at most {LONGEST_LINE}"
    for match in RUN_TOGETHER.finditer(text):
        yield text.count("\n", 0, match.start()) + 1, "elements of an example run together: one on a line of its own each"


def files(tree):
    for path in tree_files(tree):
        *folders, name = path.split("/")
        if path.endswith((".md", ".h", ".cpp", ".py", ".xml", ".txt", ".cmake")) or "." not in name:
            if path != "tests/project/check_text.py" and not SKIPPED_FOLDERS.intersection(folders):
                yield path


def problems(tree):
    found, counted = [], 0
    for path in files(tree):
        with open(os.path.join(tree, path), encoding="utf-8", errors="replace") as file:
            text = file.read()
        counted += 1
        here = list(idioms(text))
        if path.endswith((".h", ".cpp")):
            here += broken_lines(text)
        if is_page(path):
            here += problems_of_page(path, text, lambda other: os.path.exists(os.path.join(tree, other)))
        found += [f"{path}:{line}: {what}" for line, what in sorted(here)]
    return found, counted


LONG = "This sentence " + "has many words " * 11 + "indeed."
PLANTED = {  # path: (text, part of the expected finding, or None where there is nothing to find)
    "docs/a.md": (f"Short. {LONG}\n", "a sentence of 36 words"),
    "docs/b.md": (f"| a | {LONG} |\n", "a sentence of 36 words"),
    "docs/c.md": ("- A list\n- " + LONG.replace(" has", "\n  has", 1) + "\n", "a sentence of 36 words"),
    "docs/d.md": (f"```\n{LONG}\n```\n`{LONG}` and \"{LONG}\"\n", None),
    "docs/e.md": (LONG.replace("words has", "words. It has", 1) + "\n", None),
    "docs/f.md": (LONG.replace("has many", "has St. Many", 1) + "\n", "a sentence of 37 words"),
    "docs/g.md": (f"| step 3 (from t = 1 s): {LONG} |\n", None),
    "docs/deep/h.md": ("[here](../a.md) [there](gone.md#part) [web](https://host/x)\n", "a link to gone.md"),
    "README.md": (LONG, "a sentence of 36 words"),
    "tools/i.md": (LONG, None),
    "docs/j.md": ("It costs 5 ms a step.\n", '"ms a step"'),
    "framework/k.h": ("// one\n// a cell\n", None),
    "framework/l.h": ("/// values, one a node\n", '"one a node"'),
    "tools/m.py": ('print("three solves an iteration")\n', '"solves an iteration"'),
    "tools/n": ("#!/bin/sh\n# one a core\n", '"one a core"'),
    "framework/p.h": ("// " + "x" * 138 + "\n", "a line of 141 columns"),
    "framework/q.h": ("// " + "\u00b7" * 137 + "\n", None),
    "components/r.cpp": ('//   <A a="0 2\n//   0"/> <B/>\n', "run together"),
    "components/s.cpp": ('//   <A a="0 2"/> <B/>\n//   <C a="0\n//     1"/>\n', None),
    "framework/o.cpp": ("// does not solve a step, takes a step back, 5 ms per step, one a cell-wise\n", None),
}


if __name__ == "__main__":
    run(__doc__, PLANTED, problems)
