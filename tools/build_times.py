#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Prints what a build costs, from ninja's log: seconds by folder, the slowest units, and the lines of each folder of the source.

Seconds are wall time of each compiler call, summed. They are core seconds if as many calls ran at once as there are idle cores, and if no
compiler cache answered: `CCACHE_DISABLE=1 ninja -j2` in an empty folder.

Usage: tools/build_times.py BUILD [--slowest N] [--limit SECONDS]
Exit code 1 if a unit took longer than the limit, 2 if the log cannot be read."""
import argparse
import collections
import os
import subprocess
import sys

SOURCES = (".cpp", ".h", ".py", ".js", ".html", ".css")
DEEP = ("components", "tests", "tools")  # their folders have rows of their own


def units_of(path):
    """The last time [s] of each object file in a log."""
    units = {}
    with open(path) as log:
        if not log.readline().startswith("# ninja log v"):
            raise ValueError(f"{path}: not a log of ninja")
        for number, line in enumerate(log, 2):
            if line.startswith("#"):
                continue
            fields = line.rstrip("\n").split("\t")
            if len(fields) != 5:
                raise ValueError(f"{path}:{number}: expected five fields, found {len(fields)}")
            if fields[3].endswith((".o", ".gch")):
                units[fields[3]] = (int(fields[1]) - int(fields[0])) / 1000
    return units


def folder_of(path):
    parts = path.split("/")
    return "/".join(parts[:2]) if parts[0] in DEEP and len(parts) > 2 and parts[1] != "CMakeFiles" else parts[0]


def table_of(units, slowest):
    seconds, counts = collections.Counter(), collections.Counter()
    for path, time in units.items():
        seconds[folder_of(path)] += time
        counts[folder_of(path)] += 1
    yield f"{'folder':32} {'units':>6} {'seconds':>8}"
    for folder, time in seconds.most_common():
        yield f"{folder:32} {counts[folder]:6} {time:8.1f}"
    yield f"{'sum':32} {len(units):6} {sum(units.values()):8.1f}"
    yield ""
    yield f"{'seconds':>8}  slowest units"
    for path, time in sorted(units.items(), key=lambda unit: -unit[1])[:slowest]:
        yield f"{time:8.1f}  {path}"


def lines_of(root):
    """Lines of source by folder, of what git tracks."""
    lines = collections.Counter()
    names = subprocess.run(["git", "-C", root, "ls-files", "-z"], capture_output=True, text=True, check=True).stdout.split("\0")
    for name in names:
        if name.endswith(SOURCES) and os.path.isfile(os.path.join(root, name)):
            with open(os.path.join(root, name), "rb") as file:
                lines[name.split("/")[0]] += file.read().count(b"\n")
    return lines


def main():
    parser = argparse.ArgumentParser(description="what a build costs, from ninja's log")
    parser.add_argument("build", help="the build folder")
    parser.add_argument("--slowest", type=int, default=10, metavar="N", help="number of units to list")
    parser.add_argument("--limit", type=float, metavar="SECONDS", help="longest time of a unit")
    options = parser.parse_args()
    try:
        units = units_of(os.path.join(options.build, ".ninja_log"))
    except (OSError, ValueError) as error:
        print(f"build_times.py: {error}", file=sys.stderr)
        return 2
    print("\n".join(table_of(units, options.slowest)))
    print(f"\n{'folder':32} {'lines':>8}")
    for folder, count in lines_of(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))).most_common():
        print(f"{folder:32} {count:8}")
    late = sorted(path for path, time in units.items() if options.limit is not None and time > options.limit)
    for path in late:
        print(f"{path} took {units[path]:.1f} s, longer than {options.limit:g} s", file=sys.stderr)
    return 1 if late else 0


if __name__ == "__main__":
    sys.exit(main())
