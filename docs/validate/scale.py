#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""How time and memory of a block of tetrahedra grow with its size: statics, implicit and explicit steps, and the laws fitted.

  docs/validate/scale.py --stroma build/release/bin/stroma --out docs/experiments
  docs/validate/scale.py --stroma ... --out ... --cells 11 20 30 --rounds 1

Processor seconds on one thread, of the user and of the system, least of --rounds. Statics: the whole command. Steps: what each more
step takes, the difference of a long and a short run. Memory: the peak of the process. A law c N^p is fitted to the logarithms of all
sizes from 40,000 tetrahedra on. Writes scale.csv and scale.png, and prints the laws of docs/scale.md. Needs numpy and matplotlib."""
import argparse
import json
import os
import resource
import subprocess
import tempfile

SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes", "benchmarks")
CG = '<CGLinearSolver name="linear" iterations="5" tolerance="1e-30" threshold="1e-15"/>'
IMPLICIT = '<EulerImplicitSolver name="solver" rayleighStiffness="0.01" rayleighMass="0.1"/>'
STATIC = '<StaticSolver name="solver"/>'
FEM = "/block/cells/fem"
FIT_FROM = 40000  # tetrahedra

# name: (scene, what is replaced by what, settings, steps of the short and of the long run or None for the whole command, largest size)
CASES = {
    "statics, `small`, nothing named": ("statics.xml", {}, [FEM + ".method=small"], None, 10**7),
    "statics, `svd`, nothing named": ("statics.xml", {}, [], None, 10**7),
    "statics, `small`, `SparseLDLSolver`": ("statics.xml", {STATIC: STATIC + "<SparseLDLSolver/>"}, [FEM + ".method=small"], None,
                                            150000),
    "implicit step, `polar`, nothing named": ("block_320000.xml", {CG: ""}, [], (2, 10), 10**7),
    "implicit step, `polar`, 5 iterations": ("block_320000.xml", {}, [], (2, 22), 10**7),
    "explicit step, `polar`": ("block_320000.xml", {IMPLICIT: '<EulerExplicitSolver name="solver"/>', CG: ""},
                               ["/.dt=1e-5"], (2, 42), 10**7),
}


def processor_seconds():
    """Of all commands that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def command(stroma, scene, settings, steps):
    """Processor seconds of a run and its peak of memory in bytes."""
    line = [stroma, "run", scene, "-n", str(steps), "--threads", "1", "--no-record", "--quiet", "--json"]
    for setting in settings:
        line += ["--set", setting]
    before = processor_seconds()
    result = subprocess.run(line, capture_output=True, text=True)
    if result.returncode:
        raise SystemExit(result.stderr)
    return processor_seconds() - before, json.loads(result.stdout)["peak_memory_bytes"]


def measure(stroma, case, cells, rounds):
    """Seconds and bytes of a case with cells^3 cubes of five tetrahedra."""
    file, changes, settings, steps, _ = CASES[case]
    text = open(os.path.join(SCENES, file)).read()
    for old, new in changes.items():
        if old not in text:
            raise SystemExit(f"{file} has no {old}")
        text = text.replace(old, new)
    with tempfile.TemporaryDirectory() as folder:
        scene = os.path.join(folder, "block.xml")
        with open(scene, "w") as out:
            out.write(text)
        grid = settings + ["/block/grid.n=" + " ".join([str(cells + 1)] * 3)]
        short, long = steps or (0, 1)
        runs = [[command(stroma, scene, grid, n) for n in ((short, long) if steps else (long,))] for _ in range(rounds)]
    least = [min(run[k][0] for run in runs) for k in range(len(runs[0]))]
    seconds = (least[1] - least[0]) / (long - short) if steps else least[0]
    return seconds, runs[0][-1][1]


def law(np, numbers, values):
    """c and p of c N^p."""
    use = [k for k, number in enumerate(numbers) if number >= FIT_FROM]
    if len(use) < 2:
        return None
    power, factor = np.polyfit(np.log([numbers[k] for k in use]), np.log([values[k] for k in use]), 1)
    return float(np.exp(factor)), float(power)


def draw(plt, found, file):
    figure, axes = plt.subplots(1, 2, figsize=(12, 5), constrained_layout=True)
    for part, column, label in ((axes[0], 1, "processor seconds, one thread"), (axes[1], 2, "peak of memory [MB]")):
        for name, rows in found.items():
            values = [row[column] for row in rows]
            part.loglog([row[0] for row in rows], values, "o-", markersize=4, label=name.replace("`", ""))
        part.set(xlabel="tetrahedra", ylabel=label)
        part.grid(True, which="both", alpha=0.25)
    axes[0].legend(fontsize=8)
    figure.savefig(file, dpi=90)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stroma", required=True, help="the stroma command")
    parser.add_argument("--out", required=True, help="folder for scale.csv and scale.png")
    parser.add_argument("--cells", nargs="+", type=int, default=[11, 20, 30, 40, 58], help="cubes along an edge, of five tetrahedra each")
    parser.add_argument("--rounds", type=int, default=3, help="runs of each, of which the least counts (3)")
    arguments = parser.parse_args()
    stroma, found = os.path.abspath(arguments.stroma), {}
    for name, (*_, most) in CASES.items():
        found[name] = []
        for cells in arguments.cells:
            number = 5 * cells**3
            if number <= most:
                seconds, memory = measure(stroma, name, cells, arguments.rounds)
                found[name].append((number, seconds, memory / 1e6))
                print(f"  {name}: {number} {seconds:.4g} s, {memory / 1e6:.0f} MB", flush=True)
    # Not before: a peak of memory begins at that of the process that starts a command.
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np
    import stroma_run as sr
    print(sr.machine())
    rows = []
    for name, points in found.items():
        numbers = [point[0] for point in points]
        laws = [law(np, numbers, [point[column] for point in points]) for column in (1, 2)]
        rows.append([name] + [f"{1e9 * f:.3g} ns N^{p:.2f}" if k == 0 else f"{1e6 * f:.3g} bytes N^{p:.2f}"
                              for k, (f, p) in enumerate(laws)] if all(laws) else [name, "", ""])
    print(sr.markdown(["", "time", "memory"], rows))
    sr.write_csv(os.path.join(arguments.out, "scale.csv"), ["case", "tetrahedra", "processor seconds", "peak of memory [MB]"],
                 [[name, number, f"{seconds:.4g}", f"{memory:.4g}"] for name, points in found.items()
                  for number, seconds, memory in points])
    draw(plt, found, os.path.join(arguments.out, "scale.png"))


if __name__ == "__main__":
    main()
