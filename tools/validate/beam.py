# SPDX-License-Identifier: LGPL-2.1-or-later
"""The fixed beam: figures 8 and 9 of Nesme et al. 2005, by every method, against Timoshenko's beam."""
import os

import numpy as np

import stroma_run as sr

SCENE = "scenes/validation/cantilever_distributed.xml"
LENGTH, BENDING, LOAD, SHEAR, CELLS = 40.0, 20e3 * 8 * 4 / 12, 8e-3, 5 / 6 * 1e4 * 8, 6
METHODS = ("small", "large", "polar", "svd")


def deflection(stroma, method, poisson):
    """Mean deflection of the sections x = 0, 1, ... 40 m, shape (41) [m]."""
    result = stroma.run(SCENE, [f"/grid.n={20 * CELLS + 1} {CELLS + 1} {CELLS + 1}", "/beam/cut.cutting=ten",
                                f"/beam/fem.poissonRatio={poisson}", f"/beam/fem.method={method}"], steps=1)
    if result["code"]:
        raise RuntimeError(result["message"])
    rest, moved = result["frames"]["beam.dofs"][[0, -1]]
    return np.array([-(moved - rest)[np.isclose(rest[:, 0], x), 2].mean() for x in range(41)])


def slope(sunk):
    """Slope on log axes of the deflection without its linear part, over 12 to 36 m from the free end."""
    s = np.arange(41)
    from_end = sunk[::-1]
    curve = from_end - from_end[0] + (from_end[0] - from_end[1]) * s
    return np.polyfit(np.log(s[12:37]), np.log(curve[12:37]), 1)[0]


def theory():
    x = np.arange(41.0)
    bending = LOAD / (24 * BENDING) * x**2 * (x**2 - 4 * LENGTH * x + 6 * LENGTH**2)
    return bending + LOAD / SHEAR * (LENGTH * x - x**2 / 2)


def run(stroma, out, report):
    curves, rows = {"Timoshenko, nu 0": theory()}, []
    for poisson in (0, 0.3, 0.45):
        for method in METHODS:
            sunk = deflection(stroma, method, poisson)
            curves[f"{method}, nu {poisson}"] = sunk
            rows.append([method, poisson, f"{sunk[-1] * 1000:.3f}", f"{(sunk[-1] / theory()[-1] - 1) * 100:+.2f} %",
                         f"{slope(sunk):.3f}"])
        print("   beam nu", poisson, flush=True)
    rows.append(["Timoshenko", 0, f"{theory()[-1] * 1000:.3f}", "", f"{slope(theory()):.3f}"])
    sr.write_csv(os.path.join(out, "beam.csv"), ["x [m]"] + list(curves), np.column_stack([range(41), *curves.values()]))
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(figsize=(7, 5), constrained_layout=True)
    for name, sunk in curves.items():
        if name.startswith(("Timoshenko", "polar")):
            axes.semilogy(range(1, 41), sunk[1:], label=name)
    axes.set(xlabel="distance from the clamp [m]", ylabel="deflection [m]", title="Fixed beam under its weight (figure 9)")
    axes.legend()
    figure.savefig(os.path.join(out, "beam.png"), dpi=90)
    report.append("## Fixed beam (figures 8 and 9)\n\n40 x 4 x 2 m, 20 kPa, g = 1e-3 m/s2 so that linear theory holds, ten "
                  f"tetrahedra a cell, {CELLS} cells over the height. Slope: of the deflection without its linear part, seen "
                  "from the free end, on log axes; a law of degree 4 and the little that shear takes from it.\n\n" +
                  sr.markdown(["method", "nu", "tip [mm]", "against theory", "slope"], rows) + "\n![beam](beam.png)\n")
