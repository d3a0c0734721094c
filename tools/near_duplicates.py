#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Prints pairs of places in a source tree whose lines have the same shape: equal but for names, numbers and strings.

Blank lines, comments, includes and lines of punctuation do not count. Runs in more than eight places, and runs of very short lines, are too
common to be copies.

Usage: tools/near_duplicates.py [TREE] [--lines N] [--list N]"""
import argparse
import collections
import os
import re
import subprocess
import sys

SOURCES = (".cpp", ".h", ".py", ".js")
KEPT = {"if", "else", "for", "while", "return", "switch", "case", "const", "auto", "class", "struct", "template", "void", "double", "int",
        "def", "in", "not", "and", "or", "import", "function", "let"}
TOKEN = re.compile(r"""[A-Za-z_]\w*|\d[\w.]*|"(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*'|\S""")
MOST_PLACES = 8
LEAST_TEXT = 20  # letters of a shape, on average: shorter lines are alike by chance


def shape(line):
    """The line without what a copy changes, or nothing if it does not count."""
    line = line.strip()
    if line.startswith(("//", "#", "/*", "*", "import ", "from ")) or not re.search(r"\w{2}", line):
        return ""
    tokens = (word if word in KEPT else "n" if re.match(r"[A-Za-z_]", word) else "0" if word[0].isdigit() else "s" if word[0] in "\"'" else word
              for word in TOKEN.findall(line))
    return " ".join(tokens)


def shapes_of(path):
    """(number of the line, its shape) for all lines that count."""
    with open(path, encoding="utf-8", errors="replace") as file:
        return [(number, text) for number, text in enumerate(map(shape, file), 1) if text]


def pairs_of(files, length):
    """{(file, file): (longest run, line in the first, line in the second)} of runs of `length` lines or more."""
    places = collections.defaultdict(list)
    lines = {path: shapes_of(path) for path in files}
    for path, shapes in lines.items():
        for at in range(len(shapes) - length + 1):
            places[tuple(text for _, text in shapes[at:at + length])].append((path, at))
    found = {}
    for texts, run in places.items():
        if not 1 < len(run) <= MOST_PLACES or sum(map(len, texts)) < LEAST_TEXT * length:
            continue
        for i, (one, at) in enumerate(run):
            for other, there in run[i + 1:]:
                if one == other and abs(at - there) < length:
                    continue
                if at > 0 and there > 0 and lines[one][at - 1][1] == lines[other][there - 1][1]:
                    continue  # the run has begun before
                same = length
                while (at + same < len(lines[one]) and there + same < len(lines[other])
                       and lines[one][at + same][1] == lines[other][there + same][1]):
                    same += 1
                if same > found.get((one, other), (0,))[0]:
                    found[one, other] = (same, lines[one][at][0], lines[other][there][0])
    return found


def main():
    parser = argparse.ArgumentParser(description="pairs of places whose lines have the same shape")
    parser.add_argument("tree", nargs="?", default=".", help="a git checkout")
    parser.add_argument("--lines", type=int, default=10, metavar="N", help="shortest run")
    parser.add_argument("--list", type=int, default=10, metavar="N", help="number of pairs to print")
    options = parser.parse_args()
    names = subprocess.run(["git", "-C", options.tree, "ls-files", "-z"], capture_output=True, text=True, check=True).stdout.split("\0")
    files = [os.path.join(options.tree, name) for name in names if name.endswith(SOURCES)]
    found = pairs_of([path for path in files if os.path.isfile(path)], options.lines)
    relative = {path: os.path.relpath(path, options.tree) for path in files}
    for (one, other), (same, at, there) in sorted(found.items(), key=lambda pair: -pair[1][0])[:options.list]:
        print(f"{same:4} lines  {relative[one]}:{at}  {relative[other]}:{there}")
    folders = collections.Counter(relative[one].split(os.sep)[0] for one, _ in found)
    print("\n" + "\n".join(f"{folder:16} {count:6} pairs" for folder, count in sorted(folders.items())))
    return 0


if __name__ == "__main__":
    sys.exit(main())
