#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs the beams of scenes/validation and draws their deflection curves beside the theory.

  validation_picture.py --stroma build/release/bin/stroma --out docs/validation.png
  validation_picture.py --stroma ... --out quick.png --cells 4        coarser meshes, some seconds

Left: the end-loaded cantilever in large deflection for P L^2/EI = 1, 2, 3, 5, 10, a line of the mesh against the elastica.
Right: the small-load cantilever of Nesme et al. 2005, deflection without its linear part over the distance from the free
end on log axes, for three Poisson's ratios, against Timoshenko's beam. Needs numpy and matplotlib.
"""
import argparse
import gzip
import os
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes", "validation")
LOADS = (1, 2, 3, 5, 10)


def positions(stroma, scene, settings):
    """Node positions before and after one step, shape (nodes, 3) [m]."""
    with tempfile.TemporaryDirectory() as folder:
        command = [stroma, "run", os.path.join(SCENES, scene + ".xml"), "-n", "1", "--quiet", "--record", folder]
        for setting in settings:
            command += ["--set", setting]
        result = subprocess.run(command, capture_output=True, text=True)
        if result.returncode != 0:
            sys.exit(f"{' '.join(command)}\n{result.stderr}")
        with gzip.open(os.path.join(folder, "beam.dofs.state.gz"), "rt") as file:
            lines = [line.split("=")[1] for line in file if line.strip().startswith("X=")]
    return [np.array(line.split(), float).reshape(-1, 3) for line in (lines[0], lines[-1])]


def elastica(load):
    """Curve (x, drop) of the elastica, EI theta'' = -P cos theta, by shooting with the midpoint rule."""
    def curve(k):
        theta, rate, points = 0.0, k, [(0.0, 0.0)]
        step = 1 / 2000
        for _ in range(2000):
            middle = theta + step / 2 * rate
            rate_middle = rate - step / 2 * load * np.cos(theta)
            theta, rate = theta + step * rate_middle, rate - step * load * np.cos(middle)
            x, drop = points[-1]
            points.append((x + step * np.cos(middle), drop + step * np.sin(middle)))
        return rate, np.array(points)
    low, high = 0.0, float(load)
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (low, middle) if curve(middle)[0] > 0 else (middle, high)
    return curve(low)[1]


def draw_elastica(axes, stroma, cells):
    grid = f"/grid.n={50 * cells + 1} 2 {cells + 1}"
    for load in LOADS:
        theory = elastica(load)
        axes.plot(theory[:, 0], -theory[:, 1], color="0.6", linewidth=3,
                  label="elastica" if load == LOADS[0] else None)
        for method, style in (("polar", "-"), ("large", "--")):
            rest, moved = positions(stroma, "elastica", [grid, f"/beam/pull.totalForce=0 0 {-0.016 * load}",
                                                         f"/beam/fem.method={method}"])
            line = (rest[:, 1] == 0) & np.isclose(rest[:, 2], 0.01)
            axes.plot(moved[line, 0], moved[line, 2] - 0.01, style, color={"polar": "C0", "large": "C3"}[method],
                      linewidth=1, label=f"{method}, B constant" if load == LOADS[0] else None)
        axes.annotate(f"{load}", theory[-1] * [1, -1], textcoords="offset points", xytext=(4, -4))
    axes.set(xlabel="x / L", ylabel="z / L", aspect="equal", title=f"End load, P L$^2$/EI = 1 to 10 ({cells} cells high)")
    axes.legend(loc="lower left")


def draw_powers(axes, stroma, cells):
    length, bending, load, shear = 40.0, 20e3 * 8 * 4 / 12, 8e-3, 5 / 6 * 1e4 * 8
    s = np.arange(8, 37)
    axes.loglog(s, load * (s**4 / (24 * bending) - s**2 / (2 * shear)), color="0.6", linewidth=3, label="Timoshenko, nu 0")
    for number, poisson in enumerate((0, 0.3, 0.45)):
        rest, moved = positions(stroma, "cantilever_distributed",
                                [f"/grid.n={20 * cells + 1} {cells + 1} {cells + 1}", "/beam/cut.cutting=ten",
                                 f"/beam/fem.poissonRatio={poisson}"])

        def sunk(distance):
            return -(moved - rest)[np.isclose(rest[:, 0], length - distance), 2].mean()
        tangent = sunk(0) - sunk(1)
        axes.loglog(s, [sunk(d) - sunk(0) + tangent * d for d in s], f"C{number}.-", linewidth=1, markersize=4,
                    label=f"ten tetrahedra per cell, nu {poisson}")
    axes.loglog(s, 2e-9 * s**4, "k:", linewidth=1, label="slope 4")
    axes.set(xlabel="distance from the free end [m]", ylabel="deflection without its linear part [m]",
             title=f"Own weight, small load ({cells} cells high)")
    axes.legend()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stroma", required=True, help="the stroma command")
    parser.add_argument("--out", required=True, help="the picture to write")
    parser.add_argument("--cells", type=int, default=8, help="cells over the height of the beams (8)")
    arguments = parser.parse_args()
    if arguments.cells < 2 or arguments.cells % 2:
        sys.exit(f"--cells is {arguments.cells}: expected an even number, so that a line of nodes lies in the middle")
    figure, axes = plt.subplots(1, 2, figsize=(12, 5.5), constrained_layout=True)
    draw_elastica(axes[0], arguments.stroma, arguments.cells)
    draw_powers(axes[1], arguments.stroma, arguments.cells)
    figure.savefig(arguments.out, dpi=90)
    print(f"{arguments.out} written")


if __name__ == "__main__":
    main()
