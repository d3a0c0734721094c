# SPDX-License-Identifier: LGPL-2.1-or-later
"""Time a step: figure 7 of Nesme et al. 2005 (against the number of tetrahedra) and figure 4 (against the number of conjugate
gradient iterations, with and without assembling). A benchmark: the figures are medians of a run on the machine named."""
import os

import matplotlib.pyplot as plt
import numpy as np

import stroma_run as sr

SCENE = "scenes/benchmarks/truth_cube.xml"
SIZES = (4, 6, 8, 11, 14, 18)
ITERATIONS = (1, 5, 10, 20, 35, 50, 75, 100)


def milliseconds(stroma, settings, steps=60):
    result = stroma.run(SCENE, settings, steps=steps, every=10**9)
    if result["code"]:
        raise RuntimeError(result["message"])
    return result["summary"]["ms_per_step"]["median"]


def against_size(stroma, out):
    rows = []
    for n in SIZES:
        tetrahedra = 10 * (n - 1)**3
        times = [milliseconds(stroma, [f"/cube/grid.n={n} {n} {n}", f"/cube/cells/fem.method={method}"],
                              max(20, 400000 // tetrahedra)) for method in ("large", "polar", "svd")]
        rows.append([tetrahedra] + [round(time, 4) for time in times])
    table = np.array(rows, float)
    figure, axes = plt.subplots(figsize=(7, 5), constrained_layout=True)
    for column, name in enumerate(("large (QR)", "polar", "svd"), 1):
        axes.plot(table[:, 0], table[:, column], "o-", label=name)
    axes.set(xlabel="tetrahedra", ylabel="ms a step", title="B updated, 5 iterations, one core (figure 7)")
    axes.legend()
    figure.savefig(os.path.join(out, "cost_size.png"), dpi=90)
    header = ["tetrahedra", "large (QR) [ms]", "polar [ms]", "svd [ms]"]
    sr.write_csv(os.path.join(out, "cost_size.csv"), header, rows)
    nanoseconds = [[row[0]] + [f"{value * 1e6 / row[0]:.1f}" for value in row[1:]] for row in rows]
    return ("### Against the number of tetrahedra (figure 7)\n\nNanoseconds a tetrahedron and step; a constant column is a cost "
            "linear in the number.\n\n" +
            sr.markdown(["tetrahedra", "large (QR)", "polar", "svd"], nanoseconds) + "\n![cost](cost_size.png)\n")


def against_iterations(stroma, out):
    rows = []
    for iterations in ITERATIONS:
        row = [iterations]
        for assembling in ("false", "true"):
            row.append(round(milliseconds(stroma, ["/cube/grid.n=8 8 8", f"/cube/linear.iterations={iterations}",
                                                   f"/cube/cells/fem.assembling={assembling}"]), 4))
        rows.append(row)
    table = np.array(rows, float)
    difference = table[:, 1] - table[:, 2]
    above = np.flatnonzero(difference > 0)
    if len(above) and above[0] > 0:
        i = above[0]
        cross = np.interp(0, difference[i - 1:i + 1], table[i - 1:i + 1, 0])
        verdict = f"Assembling pays from about {cross:.0f} iterations on (the paper: 50)."
    else:
        verdict = "Assembling pays at every number tried." if len(above) else "Assembling does not pay at any number tried."
    (free, _), (assembled, _) = (np.polyfit(table[-3:, 0], 1000 * table[-3:, k], 1) for k in (1, 2))
    verdict += (f" An iteration costs {free:.1f} us without and {assembled:.1f} us with assembling (slopes of the last three)" +
                (": there is no crossover at any number of them." if assembled >= free else "."))
    figure, axes = plt.subplots(figsize=(7, 5), constrained_layout=True)
    axes.plot(table[:, 0], table[:, 1], "o-", label="without assembling")
    axes.plot(table[:, 0], table[:, 2], "o-", label="with assembling")
    axes.set(xlabel="conjugate gradient iterations", ylabel="ms a step", title="3,430 tetrahedra, 512 nodes (figure 4)")
    axes.legend()
    figure.savefig(os.path.join(out, "cost_iterations.png"), dpi=90)
    header = ["iterations", "without assembling [ms]", "with assembling [ms]"]
    sr.write_csv(os.path.join(out, "cost_iterations.csv"), header, rows)
    return ("### Against iterations, with and without assembling (figure 4)\n\n" + verdict + "\n\n" +
            sr.markdown(header, rows) + "\n![cost](cost_iterations.png)\n")


def run(stroma, out, report):
    report.append("## Time a step\n\n" + against_size(stroma, out) + "\n" + against_iterations(stroma, out))
