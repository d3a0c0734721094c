#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs the stability matrix (tests/stability/test_matrix.cpp) and writes its tables, a page each.

  docs/validate/stability.py --build build/release --out docs/stability            every cell, an hour on one core
  docs/validate/stability.py --build build/release --out docs/stability --sample   the cells that ctest runs

docs/stability.md says in prose what these tables show. It is written by hand: read it again after a new run.
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

HEAD = """# {title}

Written by `docs/validate/stability.py --build build/release --out docs/stability` ({arguments}; {date}, {machine}).

{text}
"""

README = """What the matrix of force fields, methods and implicit integrators ends with, from bad shapes and with extreme numbers. The
conclusions are in [stability.md](../stability.md).

- [Integrators](integrators.md), each with all force fields
- [Force fields](force_fields.md), each with all integrators
- [Sentences](sentences.md) with which runs end

## The body

- 27 nodes, 0.2 m wide, E = 5000 Pa, nu = 0.4, density 1000 kg/m3, held at four corners. dt = 0.01 s where the column does
  not say otherwise. Solver: SparseLDLSolver.
- A force field without elements takes the example of its manual page. "(supported)": a spring to its place had to give every
  node a rest shape.
- The slowest motion is measured. Mass damping makes it critically damped, and it decides how many steps are made.
- Trapezoid, Newmark and midpoint damp nothing themselves. Under them the body also has a viscosity of one step
  (`rayleighStiffness` = dt). Without any, a body that is pulled has no reason to rest.
- Stresses that relax and fluid that flows do so faster in stiffer bodies, as their motions are faster.
- "inverted" to "random": the free nodes start mirrored, in a plane, on a line, in a point, at random places. In the other
  columns the body starts pulled and twisted by a tenth of its size.
- Steps of 1e-5 s are made of stiffer bodies. 5000 Pa would need 114,000 of them.

## The letters

| letter | what a cell ends with |
|---|---|
| R | recovered: within 1e-6 of the size of the rest shape, for five steps |
| S | stopped with a sentence that names step, integrator, force field, element and reason. The states are the last good ones. Statics: not converged, with the same words |
| k | kept, in doubt: at rest in another shape, within three sizes. A sentence names the force field or the mesh, how many elements are inverted, flat, folded or strained beyond a linear law, and the worst. Or the body lies still with more energy than its rest shape has, a force was a step late, or Newton's method did not converge |
| r | rings, in doubt: bounded. The sentence says that velocities change sign from step to step, because a rule without damping is far above the fast motions |
| a | astray, in doubt: moving, growing or far away. A sentence as for k, or on energy that came from nowhere, or on a body many times its size |
| u | under way: the steps made are too few to tell; the energy has not grown |
| E | elsewhere: at rest in another shape, in silence |
| M | moving: neither at rest nor any of the above, in silence |
| B | broken: a number that is not finite, or a stop without a sentence |

With `stroma run --strict` a run that ends with k, r or a has exit code 3, as S has. The test fails on B, E and M. Where the
integrator damps it fails on a too, unless the list in `tests/stability/test_matrix.cpp` names the cell and the reason.

In a cell of a table: how many runs end so, and in brackets the largest number of steps to recovery."""

WIDE = """The letters are those of [the first page](README.md). In a cell: how many {others} end so, and in brackets the largest number
of steps to recovery."""


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


def shares(cells, row):
    """Per cent of the cells of a row: recovered, stopped, in doubt with a sentence, in silence."""
    groups = [ENDINGS[:1], ENDINGS[1:2], SAID, ENDINGS[ENDINGS.index("under way"):]]
    lines = ["| | recovered | stopped | in doubt, said | in silence |", "|---|---|---|---|---|"]
    found = collections.defaultdict(list)
    for cell in cells:
        found[cell[row]].append(cell["ending"])
    for name, endings in found.items():
        parts = [f"{100 * sum(ending in group for ending in endings) / len(endings):.1f} %" for group in groups]
        lines.append(f"| {name} | " + " | ".join(parts) + " |")
    return "\n".join(lines) + "\n"


def sentences(cells):
    """One example of a sentence for each kind of stop, and all cells that end in silence."""
    lines, seen = [], set()
    for cell in cells:
        if cell["ending"] == "stopped" or cell["ending"] in SAID:
            kind = (cell["ending"], cell["row"].split()[0], cell["text"].split("solver")[-1][:30])
            if kind not in seen and len(seen) < 16:
                seen.add(kind)
                lines.append(f"- {cell['row']}, {cell['integrator']}, {cell['condition']}: `{cell['text']}`")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default="build/release")
    parser.add_argument("--out", default="docs/stability", help="folder for the pages")
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
    os.makedirs(options.out, exist_ok=True)
    for name, (title, text) in pages(cells).items():
        head = HEAD.format(title=title, arguments=part, date=datetime.date.today(), machine=platform.machine(), text=text)
        with open(os.path.join(options.out, name), "w", encoding="utf-8") as stream:
            stream.write(head)


def pages(cells):
    """File name: title and text of each page."""
    everything = [dict(cell, all="all") for cell in cells]
    integrators = WIDE.format(others="force fields") + "\n\n" + table(cells, "integrator", "condition")
    force_fields = WIDE.format(others="integrators") + "\n\n" + table(cells, "row", "condition")
    first = "\n".join([README, "\n## Endings\n", endings(cells), "## Conditions\n", shares(cells, "condition"),
                       table(everything, "all", "condition"), "## Integrators\n", shares(cells, "integrator"),
                       "## Force fields\n", shares(cells, "row"), "## In silence\n", silence(cells)])
    return {"README.md": ("The stability matrix", first.rstrip("\n")),
            "integrators.md": ("Stability: integrators", integrators.rstrip("\n")),
            "force_fields.md": ("Stability: force fields", force_fields.rstrip("\n")),
            "sentences.md": ("Stability: sentences", "Some of them:\n\n" + "\n".join(sentences(cells)))}


def endings(cells):
    number = collections.Counter(cell["ending"] for cell in cells)
    text = "| ending | cells | share |\n|---|---|---|\n"
    for ending in ENDINGS:
        text += f"| {SHORT[ending]}, {ending} | {number[ending]} | {100 * number[ending] / len(cells):.1f} % |\n"
    return text


def silence(cells):
    silent = [cell for cell in cells if cell["ending"] in ENDINGS[ENDINGS.index("elsewhere"):]]
    text = f"{len(silent)} of {len(cells)} cells end away from their shape without a sentence.\n"
    for reason in ordered(cell["reason"] for cell in silent):
        text += f"\n{(reason[:1].upper() + reason[1:]) or 'Not in the list, so that the test fails'}:\n\n"
        for cell in silent:
            if cell["reason"] == reason:
                text += f"- {cell['row']}, {cell['integrator']}, {cell['condition']}: {cell['ending']}," \
                        f" {cell['distance']} sizes away. {cell['text']}".rstrip() + "\n"
    return text


if __name__ == "__main__":
    main()
