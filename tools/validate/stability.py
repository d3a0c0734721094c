#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs the stability matrix (tests/stability/test_matrix.cpp) and writes its table.

  tools/validate/stability.py --build build/release --out docs/stability.md            every cell, an hour on one core
  tools/validate/stability.py --build build/release --out docs/stability.md --sample   the cells that ctest runs
"""
import argparse
import collections
import datetime
import os
import platform
import subprocess
import sys

ENDINGS = ["recovered", "stopped", "kept, said", "rings, said", "astray, said", "under way", "elsewhere", "moving", "broken"]
SHORT = {"recovered": "R", "stopped": "S", "kept, said": "k", "rings, said": "r", "astray, said": "a", "under way": "u", "elsewhere": "E",
         "moving": "M", "broken": "B"}
SAID = ENDINGS[2:5]

TEXT = """# Stability

Every force field, with every method, under every implicit integrator, from shapes and with numbers that no tissue meets.
Written by `tools/validate/stability.py --build build/release --out docs/stability.md` ({arguments}; {date}, {machine}).

A body of 27 nodes (0.2 m, E = 5000 Pa, nu = 0.4, density 1000 kg/m3, dt = 0.01 s where the column does not say otherwise),
held at four corners; for force fields without elements the example of their manual page, "(supported)" where a spring to
its place had to give every node a rest shape. The slowest motion is measured: mass damping makes it critically damped, and
it decides how many steps are made. Under the rules that damp nothing themselves (trapezoid, Newmark, midpoint) the body has
a viscosity of one step beside (`rayleighStiffness` = dt): without any, a body that is pulled has no reason to rest. Stresses
that relax and fluid that flows do so faster in stiffer bodies, as their motions are. "inverted" to "random": the free nodes
start mirrored, in a plane, on a line, in a point, at random places; the other columns start pulled and twisted by a tenth of
the size. Steps of 1e-5 s are made of stiffer bodies, of which 5000 Pa would need 114,000. Solver: SparseLDLSolver.

| letter | what a cell ends with |
|---|---|
| R | recovered: within 1e-6 of the size of the rest shape, for five steps |
| S | stopped with a sentence that names step, integrator, force field, element and reason; states are the last good ones. Statics: not converged, with the same words |
| k | ended in doubt, at rest in another shape, within three sizes: the run's sentence names the force field or the mesh and how many elements are inverted, flat, folded, or strained beyond a linear law, and the worst; or a force that is a step late; or that Newton's method did not converge |
| r | ended in doubt, bounded: the sentence says that velocities change sign from step to step, because a rule without damping is far above the fast motions |
| a | ended in doubt, moving, growing or far away: a sentence as for k, or on energy that came from nowhere or a body many times its size |
| u | under way: the steps made are too few to tell; the energy has not grown |
| E | elsewhere: at rest in another shape, in silence |
| M | moving: neither at rest nor any of the above, in silence |
| B | broken: a number that is not finite, or a stop without a sentence |

`stroma run --strict` makes of k, r and a what S is: the run ends with the sentence and exit code 3. B fails the test; so do E,
M and, where the integrator damps, a, but for the cells that a list in `tests/stability/test_matrix.cpp` names; the reason is
given below for every such cell.

In a cell: how many of the integrators end so, the largest number of steps to recovery in brackets.
"""


def run(build, whole, jobs, rows):
    environment = dict(os.environ)
    environment.pop("STROMA_WHOLE_MATRIX", None)
    if whole:
        environment["STROMA_WHOLE_MATRIX"] = "1"
    command = [os.path.join(build, "bin/test_stability"), f"--gtest_filter=*Matrix*{rows}*"]
    processes = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True,
                                  env={**environment, "GTEST_TOTAL_SHARDS": str(jobs), "GTEST_SHARD_INDEX": str(i)})
                 for i in range(jobs)]
    return [line.rstrip("\n") for process in processes for line in process.communicate()[0].splitlines()]


def ordered(values):
    return list(dict.fromkeys(values))


def counts(cells):
    number = collections.Counter(cell["ending"] for cell in cells)
    steps = [cell["steps"] for cell in cells if cell["ending"] == "recovered"]
    parts = []
    for ending in ENDINGS:
        if number[ending]:
            parts.append(f"{number[ending]}{SHORT[ending]}" + (f" ({max(steps)})" if ending == "recovered" else ""))
    return " ".join(parts) or "-"


def table(cells, row, column):
    columns = ordered(cell[column] for cell in cells)
    lines = [f"| | {' | '.join(columns)} |", "|---" * (len(columns) + 1) + "|"]
    found = collections.defaultdict(list)
    for cell in cells:
        found[cell[row], cell[column]].append(cell)
    for name in ordered(cell[row] for cell in cells):
        lines.append(f"| {name} | " + " | ".join(counts(found[name, c]) for c in columns) + " |")
    return "\n".join(lines) + "\n"


def sentences(cells):
    """One example of a sentence for each kind of stop, and all cells that end in silence."""
    lines, seen = [], set()
    for cell in cells:
        if cell["ending"] == "stopped" or cell["ending"] in SAID:
            kind = (cell["ending"], cell["row"].split()[0], cell["text"].split("solver")[-1][:30])
            if kind not in seen and len(seen) < 16:
                seen.add(kind)
                lines.append(f"- {cell['row']}, {cell['integrator']}, {cell['condition']}: {cell['text']}")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default="build/release")
    parser.add_argument("--out", default="docs/stability.md")
    parser.add_argument("--sample", action="store_true", help="the cells that ctest runs instead of all")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--rows", default="", help="only rows with this in their name")
    parser.add_argument("--from", dest="source", help="format the lines of this file (an earlier run's output) instead")
    options = parser.parse_args()
    if options.source:
        with open(options.source) as stream:
            output = stream.read().splitlines()
    else:
        output = run(options.build, not options.sample, options.jobs, options.rows)
    cells = []
    for line in output:
        if line.startswith("cell|"):
            _, row, integrator, condition, ending, steps, distance, folded, reason, text = line.split("|", 9)
            cells.append(dict(row=row, integrator=integrator, condition=condition, ending=ending, steps=int(steps),
                              distance=distance, folded=folded, reason=reason, text=text))
    if not cells:
        sys.exit("stability.py: the matrix printed no cell")
    part = f"{len(cells)} cells" + (", the sample that ctest runs" if options.sample else "")
    text = TEXT.format(arguments=part, date=datetime.date.today(), machine=platform.machine())
    text += "\n" + table([dict(cell, all="all") for cell in cells], "all", "condition")
    text += "\n## Integrators\n\n" + table(cells, "integrator", "condition")
    text += "\n## Force fields\n\n" + table(cells, "row", "condition")
    text += "\n## Sentences\n\nSome of them:\n\n" + "\n".join(sentences(cells)) + "\n"
    number = collections.Counter(cell["ending"] for cell in cells)
    text += "\n## Counts\n\n| ending | cells | share |\n|---|---|---|\n"
    for ending in ENDINGS:
        text += f"| {SHORT[ending]}, {ending} | {number[ending]} | {100 * number[ending] / len(cells):.1f} % |\n"
    silent = [cell for cell in cells if cell["ending"] in ENDINGS[ENDINGS.index("elsewhere"):]]
    text += f"\n## In silence\n\n{len(silent)} of {len(cells)} cells end away from their shape without a sentence.\n"
    for reason in ordered(cell["reason"] for cell in silent):
        text += f"\n{(reason[:1].upper() + reason[1:]) or 'Not in the list, so that the test fails'}:\n\n"
        for cell in silent:
            if cell["reason"] == reason:
                text += f"- {cell['row']}, {cell['integrator']}, {cell['condition']}: {cell['ending']}," \
                        f" {cell['distance']} sizes away. {cell['text']}".rstrip() + "\n"
    with open(options.out, "w") as stream:
        stream.write(text)


if __name__ == "__main__":
    main()
