# SPDX-License-Identifier: LGPL-2.1-or-later
"""Time per step: figure 7 of Nesme et al. 2005 (against the number of cells) and figure 4 (against the number of conjugate
gradient iterations, with and without assembling). A benchmark: the figures are medians of a run on the machine named."""
import os

import matplotlib.pyplot as plt
import numpy as np

import stroma_run as sr
import variants

SCENE = "scenes/benchmarks/truth_cube.xml"
CELLS = {"tetrahedra": 10, "hexahedra": 1}  # a cell of the grid
SIZES = (4, 6, 8, 11, 14, 18)  # nodes on an edge
ITERATIONS = (1, 5, 10, 20, 35, 50, 75, 100)
ITERATED = [("polar", 1, 0), ("polar", 0, 0), ("small", 0, 0)]
GRID = 8  # nodes on an edge of the cube of figure 4
RUNS = 5


def milliseconds(stroma, cells, variant, nodes, assembling, iterations=5, steps=60):
    """A step: the median of RUNS runs."""
    fem = "/cube/cells/fem"
    settings = variants.settings(*variant, fem) + [f"/cube/grid.n={nodes} {nodes} {nodes}",
                                                   f"/cube/linear.iterations={iterations}",
                                                   f"{fem}.assembling={'true' if assembling else 'false'}"]
    times = []
    for _ in range(RUNS):
        result = stroma.run(variants.scene(SCENE, cells), settings, steps=steps, every=10**9)
        if result["code"]:
            raise RuntimeError(result["message"])
        times.append(result["summary"]["ms_per_step"]["median"])
    return round(float(np.median(times)), 4)


def panels(titles, labels):
    """A picture of a panel for each kind of cell, with `titles` and `labels` (of the x axis) by kind."""
    figure, axes = plt.subplots(1, 2, figsize=(11, 5), constrained_layout=True)
    axes = dict(zip(variants.SUFFIXES, axes))
    for cells, part in axes.items():
        part.set(xlabel=labels[cells], ylabel="ms per step", title=titles[cells])
    return figure, axes


def against_size(stroma, out):
    compared = variants.UPDATED_B + variants.CONSTANT_B
    names = [variants.name(*variant) for variant in compared]
    times, numbers = {}, {}
    steps = {n: max(20, 40000 // (n - 1)**3) for n in SIZES}
    figure, axes = panels(dict.fromkeys(variants.SUFFIXES, "Matrix-free, 5 iterations, one core (figure 7)"),
                          {cells: cells for cells in variants.SUFFIXES})
    for cells in variants.SUFFIXES:
        numbers[cells] = [CELLS[cells] * (n - 1)**3 for n in SIZES]
        times[cells] = np.array([[milliseconds(stroma, cells, variant, n, assembling=False, steps=steps[n])
                                  for variant in compared] for n in SIZES])
        for name, variant, curve in zip(names, compared, times[cells].T):
            colour = "C" + str(variants.METHODS.index(variant[0]))
            axes[cells].plot(numbers[cells], curve, "o-" if variant[1] else "s--", color=colour, label=name, markersize=4)
        axes[cells].legend()
        print("  ", cells, "against size", flush=True)
    figure.savefig(os.path.join(out, "cost_size.png"), dpi=90)
    sr.write_csv(os.path.join(out, "cost_size.csv"), ["cells", "number"] + [name + " [ms]" for name in names],
                 [[cells, number, *row] for cells in times for number, row in zip(numbers[cells], times[cells])])
    tables = [sr.markdown([cells] + names, [[number] + [f"{time * 1e6 / number:.1f}" for time in row]
                                            for number, row in zip(numbers[cells], times[cells])]) for cells in times]
    return ("### Against the number of cells (figure 7)\n\nNanoseconds a cell and step, matrix-free; a constant column is a "
            "cost linear in the number. Hexahedra are boxes here, and boxes of a constant B have a product of their own, which "
            "other shapes lack.\n\n" + "\n".join(tables) + "\n" + compare(times, names) + "\n![cost](cost_size.png)\n")


def compare(times, names):
    """What the paper says of QR against polar and of hexahedra against tetrahedra, as ratios."""
    large, polar, constant = (names.index(name) for name in ("large, B", "polar, B", "polar"))
    qr = {cells: np.median(times[cells][:, large] / times[cells][:, polar]) for cells in times}
    hexahedra = {k: np.median(times["hexahedra"][:, k] / times["tetrahedra"][:, k]) for k in (polar, constant)}
    return ("Medians over the sizes:\n\n" + sr.markdown(
        ["ratio of the times of a step", "here", "the paper"],
        [["large, B over polar, B; tetrahedra", f"{qr['tetrahedra']:.2f}", "about 0.7 (section 5.2)"],
         ["large, B over polar, B; hexahedra", f"{qr['hexahedra']:.2f}", "1 (section 5.2)"],
         ["hexahedra over tetrahedra, ten in their place; polar, B", f"{hexahedra[polar]:.2f}",
          "150/80 = 1.9 (table 3); 20 (section 5.2), 2 if meant an element"],
         ["hexahedra over tetrahedra, ten in their place; polar", f"{hexahedra[constant]:.2f}", "24/75 = 0.32 (table 3)"]]))


def crossover(free, assembled):
    """Where the lines (ms per iteration, ms at the start) cross, in words."""
    slope, start = assembled - free
    if slope * start >= 0:
        return f"nowhere, {'matrix-free' if slope > 0 else 'assembled'} is faster throughout"
    return f"{-start / slope:.0f}, assembled is faster {'beyond' if slope < 0 else 'below'}"


def blocks(cells):
    """3x3 blocks of the matrix of a grid: hexahedra couple all nodes of a cell; ten tetrahedra all but opposite corners."""
    return (3 * GRID - 2)**3 - (8 * (GRID - 1)**3 if cells == "tetrahedra" else 0)


def against_iterations(stroma, out):
    names = [f"{variants.name(*variant)}, {way}" for variant in ITERATED for way in ("matrix-free", "assembled")]
    count = {cells: f"{CELLS[cells] * (GRID - 1)**3:,} {cells}" for cells in variants.SUFFIXES}
    figure, axes = panels({cells: f"{count[cells]}, {GRID**3} nodes (figure 4)" for cells in count},
                          dict.fromkeys(count, "conjugate gradient iterations"))
    lines, rows, tables = [], [], []
    for cells in variants.SUFFIXES:
        times = np.array([[milliseconds(stroma, cells, variant, GRID, assembling, iterations)
                           for variant in ITERATED for assembling in (False, True)] for iterations in ITERATIONS])
        fits = np.polyfit(ITERATIONS, times, 1).T
        for variant, free, assembled in zip(ITERATED, fits[::2], fits[1::2]):
            lines.append([cells, variants.name(*variant), *(f"{1000 * value:.1f}" for value in (*free[::-1], *assembled[::-1])),
                          f"{1e6 * assembled[0] / blocks(cells):.1f}", crossover(free, assembled)])
        for k, (name, curve) in enumerate(zip(names, times.T)):
            axes[cells].plot(ITERATIONS, curve, "s--" if k % 2 else "o-", color=f"C{k // 2}", label=name, markersize=4)
        axes[cells].legend()
        rows += [[cells, iterations, *row] for iterations, row in zip(ITERATIONS, times)]
        tables.append(sr.markdown([f"{cells}: iterations"] + [name + " [ms]" for name in names],
                                  [[iterations, *row] for iterations, row in zip(ITERATIONS, times)]))
        print("  ", cells, "against iterations", flush=True)
    top = max(part.get_ylim()[1] for part in axes.values())
    for part in axes.values():
        part.set_ylim(0, top)
    figure.savefig(os.path.join(out, "cost_iterations.png"), dpi=90)
    sr.write_csv(os.path.join(out, "cost_iterations.csv"), ["cells", "iterations"] + [name + " [ms]" for name in names], rows)
    return ("### Against iterations, with and without assembling (figure 4)\n\nThe same "
            f"{GRID**3} nodes as {' or '.join(count.values())}. A line is fitted to the times over all numbers of iterations: "
            "start, what a step costs without any, and what each iteration costs. The paper's lines for tetrahedra cross at about "
            "50 iterations, beyond which assembling pays; for hexahedra it has none. It counts 6,660 multiplications for one "
            "tetrahedron's product without assembling (section 3.2), which may be why; this was not tested here. "
            "A product with the matrix passes over its 3x3 blocks, "
            f"{blocks('tetrahedra'):,} of the tetrahedra and {blocks('hexahedra'):,} of the hexahedra.\n\n" +
            sr.markdown(["cells", "method", "matrix-free: start [us]", "an iteration [us]", "assembled: start [us]",
                         "an iteration [us]", "a block [ns]", "crossover at"], lines) + "\n" + "\n".join(tables) +
            "\n![cost](cost_iterations.png)\n")


def run(stroma, out, report):
    report.append(f"## Time per step\n\nMedians of {RUNS} runs.\n\n" + against_size(stroma, out) + "\n" +
                  against_iterations(stroma, out))
