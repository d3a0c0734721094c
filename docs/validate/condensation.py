#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Time per step of the condensed solvers (Bro-Nielsen and Cotin 1996) against the nodes inside, kept and loaded.

  docs/validate/condensation.py --stroma build/release/bin/stroma --out docs/experiments
  docs/validate/condensation.py --stroma build/release/bin/stroma --start    the precomputation and starts from its file

FD, FS, CD and CS are the paper's: full or condensed, dynamic or static with selective products. Beside them a static step by
conjugate gradients and one by a sparse factorisation kept over the steps. CD neglects the mass inside, as published; "CD, exact" keeps it. Blocks of tetrahedra held at their floor; each number
is the least of three runs' medians. Writes OUT/condensation.md, .csv and .png; about ten minutes. Needs numpy and matplotlib.
"""
import argparse
import datetime
import os
import random
import subprocess
import tempfile
import time
import json

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402

import stroma_run as sr  # noqa: E402

CONDENSED_STATIC = '<CondensedStaticSolver surfaceIndices="{kept}"/>'
CONDENSED_DYNAMIC = '<CondensedDynamicSolver interiorMass="neglected" surfaceIndices="{kept}"/>'
CONDENSED_EXACT = '<CondensedDynamicSolver surfaceIndices="{kept}"/>'
SOLVERS = {  # solver, steps per run
    "CS": (CONDENSED_STATIC, 2000),
    "CD": (CONDENSED_DYNAMIC, 200),
    "CD, exact": (CONDENSED_EXACT, 50),
    "FS": ('<CondensedStaticSolver condensed="false"/>', 1000),
    "FD": ('<CondensedDynamicSolver condensed="false"/>', 50),
    "sparse direct": ('<StaticSolver newton_iterations="1"/><SparseLDLSolver/>', 20),
    "CG": ('<StaticSolver newton_iterations="1"/><CGLinearSolver iterations="2000" tolerance="1e-8" threshold="1e-30"/>', 10),
}
LARGEST_FULL = 3000  # nodes of which FS keeps the inverse: 650 MB


def scene(n, solver, kept, loaded):
    """A block of n^3 nodes; `kept` and `loaded` count nodes of its free surface, chosen at random."""
    inside = range(1, n - 1)
    surface = [i + n * (j + n * k) for k in range(1, n) for j in range(n) for i in range(n)
               if not (i in inside and j in inside and k < n - 1)]
    chosen = random.Random(1)
    some = sorted(chosen.sample(surface, kept))
    points = chosen.sample(some, loaded)
    words = lambda numbers: " ".join(map(str, numbers))  # noqa: E731
    size = 0.01 * n
    return f"""<Node name="root" dt="0.02" gravity="0 0 0">{solver.format(kept=words(some))}
<Node name="source"><RegularGridTopology name="grid" n="{n} {n} {n}" min="0 0 0" max="{size} {size} {size}"/></Node>
<Node name="body"><TetrahedronSetTopologyContainer name="cells"/>
<Hexa2TetraTopologicalMapping input="@../source/grid" output="@cells"/><MechanicalObject name="dofs"/>
<UniformMass totalMass="0.5"/>
<TetrahedronFEMForceField name="fem" method="small" youngModulus="50000" poissonRatio="0.4"/>
<FixedProjectiveConstraint indices="{words(range(n * n))}"/>
<LinearForceField points="{words(points)}" times="0 1e6" forces="0 0 0  100 200 300"/></Node></Node>"""


def milliseconds(stroma, name, n, kept, loaded):
    """The least of three medians [ms], and the seconds until the first step; None where the method does not fit."""
    solver, steps = SOLVERS[name]
    if name == "FS" and n**3 > LARGEST_FULL:
        return None, None
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "block.xml")
        if "condensed" in solver.lower():
            solver = solver.replace("/>", f' cacheFolder="{folder}"/>', 1)
        with open(path, "w") as file:
            file.write(scene(n, solver, kept, loaded))
        times, starts = [], []
        for _ in range(3):
            result = subprocess.run([stroma, "run", path, "-n", str(steps), "--quiet", "--no-record", "--json", "-"],
                                    capture_output=True, text=True)
            if result.returncode not in (0, 3) or not result.stdout.startswith("{"):
                raise RuntimeError(f"{name}, {n}^3 nodes: {result.stderr}")
            summary = json.loads(result.stdout)
            times.append(summary["ms_per_step"]["median"])
            starts.append(summary["load_seconds"])
    print(f"{name:14} {n}^3 nodes, {kept} kept, {loaded} loaded: {min(times):.4g} ms", flush=True)
    return min(times), starts[0]


def number(value):
    return "" if value is None else f"{value:.3g}"


def sweep(stroma, title, column, cases, names, rows):
    """`cases`: (what the column shows, n, kept, loaded)."""
    table, curves = [], {name: ([], []) for name in names}
    for shown, n, kept, loaded in cases:
        line = [shown]
        for name in names:
            each, start = milliseconds(stroma, name, n, kept, loaded)
            line.append(number(each))
            if each is None:
                continue
            rows.append([title, name, n**3 - n * n, kept, loaded, each, start])
            curves[name][0].append(shown)
            curves[name][1].append(each)
        table.append(line)
    return f"## {title}\n\n" + sr.markdown([column] + list(names), table), curves


def starts(stroma):
    """Prints the wall time of whole commands: the precomputation with a step, and starts without one."""
    with tempfile.TemporaryDirectory() as folder:
        def seconds(solver, steps):
            path = os.path.join(folder, "block.xml")
            with open(path, "w") as file:
                file.write(scene(28, solver, 2000, 3))
            begin = time.perf_counter()
            subprocess.run([stroma, "run", path, "-n", str(steps), "--quiet", "--no-record"], check=True, capture_output=True)
            return time.perf_counter() - begin
        plain = sorted(seconds('<EulerImplicitSolver/><CGLinearSolver/>', 0) for _ in range(7))[3]
        print(f"the scene with EulerImplicitSolver and CGLinearSolver: {plain:.3f} s")
        for name in ("CS", "CD", "CD, exact"):
            solver = SOLVERS[name][0].replace("/>", f' cacheFolder="{folder}"/>', 1)
            first = seconds(solver, 1)
            again = sorted(seconds(solver, 0) for _ in range(7))
            size = max(os.path.getsize(os.path.join(folder, f)) for f in os.listdir(folder) if f.endswith(".condensed"))
            print(f"{name}: {first:.1f} s with the precomputation; {again[3]:.3f} s from its file (median of 7; {again[0]:.3f} to "
                  f"{again[-1]:.3f}), the scene included; {size / 1e9:.2f} GB")
            for f in os.listdir(folder):
                os.remove(os.path.join(folder, f))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stroma", required=True, help="the stroma command")
    parser.add_argument("--out", help="folder for the table and the figure")
    parser.add_argument("--start", action="store_true", help="2,000 kept nodes over 19,168 inside: time to the first step")
    arguments = parser.parse_args()
    stroma = os.path.abspath(arguments.stroma)
    if arguments.start:
        return starts(stroma)
    if not arguments.out:
        parser.error("--out or --start is needed")
    every = list(SOLVERS)
    sweeps = [
        ("Against the nodes inside (300 kept, 3 loaded)", "nodes inside",
         [(n**3 - n * n - 300, n, 300, 3) for n in (10, 12, 14, 18, 22)], every),
        ("Against the kept nodes (block of 18^3 nodes, 3 loaded; 1412 are its whole free surface)", "kept nodes",
         [(kept, 18, kept, 3) for kept in (50, 100, 200, 400, 800, 1412)], every),
        ("Against the loaded nodes (block of 14^3 nodes, 800 kept)", "loaded nodes",
         [(loaded, 14, 800, loaded) for loaded in (1, 3, 10, 30, 100, 300, 800)], every),
    ]
    rows, texts = [], []
    figure, axes = plt.subplots(1, 3, figsize=(14, 4.5), constrained_layout=True)
    for axis, (title, column, cases, names) in zip(axes, sweeps):
        text, curves = sweep(stroma, title, column, cases, names, rows)
        texts.append(text)
        for name, (x, y) in curves.items():
            axis.loglog(x, y, "o-", label=name)
        axis.set(xlabel=column, ylabel="ms per step", title=title.split(" (")[0])
        axis.legend()
    figure.savefig(os.path.join(arguments.out, "condensation.png"), dpi=90)
    sr.write_csv(os.path.join(arguments.out, "condensation.csv"),
                 ["sweep", "method", "free nodes", "kept", "loaded", "ms per step", "seconds to the first step"], rows)
    head = (f"# Condensation, explicit inverse and selective products\n\nWritten by `docs/validate/condensation.py` on "
            f"{datetime.date.today()}; {sr.machine()}. Milliseconds per step on one core, the whole step; every load changes in "
            "every step. FD takes the sparse factor, which is measured to be faster than the inverse of these blocks. FS is left out "
            f"above {LARGEST_FULL} nodes. CS and CD work in memory-mapped files of the precomputation.\n\n"
            "A condensed step costs the same whatever lies inside, where the mass inside is left out or shared. A selective one goes with the loaded nodes, once their "
            "columns no longer fit into the cache. A dynamic step reads half of the inverse whatever is loaded. A static one "
            "with every node loaded reads all of it. CD leaves the mass inside out, as published. The exact form, whose motion is that of "
            "FD, sweeps through the inside in each step and costs more than FD. Where the mass inside counts, condensed=\"false\" is the "
            "faster solver.\n\n")
    with open(os.path.join(arguments.out, "condensation.md"), "w") as file:
        file.write(head + "\n".join(texts) + "\n![ms per step](condensation.png)\n")


if __name__ == "__main__":
    main()
