# SPDX-License-Identifier: LGPL-2.1-or-later
"""The truth cube: tables 1 to 3 of Nesme et al. 2005 against the measured beads of Kerdok et al. 2003.

The model is centred on the mean of the 343 beads at rest, its z the negative of the data's. A bead's computed place is its
place at rest plus the displacement there, interpolated trilinearly in its cell; the deviation is the distance to the measured
place over 80 mm. "rigid shift removed" takes the mean of the difference vectors out first.
"""
import os

import numpy as np

import stroma_run as sr

SIZE, CELLS = 0.08, 8
COMPRESSIONS = ("5", "12.5", "18.25")
FEM = "/fem."
TETS, HEXES, PHYMUL = ("scenes/validation/truth_cube_" + name for name in ("tetrahedra", "hexahedra", "phymul"))

# The paper's rows: name, scene, method, B, V, and mean, min, max, standard deviation [%] at 5, 12.5 and 18.25 %; ms a step.
ROWS = [
    ("tets, linear", TETS, "small", 0, 0, (1.06, .09, 2.92, .62), (1.53, .08, 4.38, .88), (2.08, .27, 5.32, 1.03), 40),
    ("tets, QR, no B", TETS, "large", 0, 0, (1.04, .09, 2.90, .61), (1.42, .11, 4.16, .82), (1.69, .10, 4.78, .94), 57),
    ("tets, QR, B", TETS, "large", 1, 0, (1.06, .06, 2.89, .59), (1.54, .2, 4.24, .77), (2.13, .64, 5.39, .91), 58),
    ("tets, polar, no B", TETS, "polar", 0, 0, (1.06, .08, 2.92, .62), (1.56, .13, 4.43, .88), (2.24, .44, 5.37, 1.05), 75),
    ("tets, polar, B", TETS, "polar", 1, 0, (1.05, .09, 2.88, .61), (1.44, .11, 3.89, .79), (1.77, .15, 4.25, .88), 80),
    ("tets, polar, B and V", TETS, "polar", 1, 1, (1.06, .08, 2.85, .60), (1.46, .12, 3.78, .77), (1.81, .18, 3.96, .84), 81),
    ("tets, svd, B", TETS, "svd", 1, 0, None, None, None, None),
    ("tets, Green-Lagrange", TETS, "green", 0, 0, None, None, None, None),
    ("hexes, QR, B", HEXES, "large", 1, 0, (1.05, .09, 2.88, .61), (1.44, .09, 3.9, .8), (1.76, .09, 4.36, .92), 150),
    ("hexes, polar, no B", HEXES, "polar", 0, 0, (1.65, .08, 3.66, .79), (3.27, .44, 6.83, 1.39), (4.97, .91, 9.57, 1.89), 24),
    ("hexes, polar, B", HEXES, "polar", 1, 0, (1.06, .09, 2.88, .60), (1.47, .09, 3.87, .78), (1.82, .14, 4.16, .87), 150),
    ("hexes, small deformation (Ansys)", HEXES, "small", 0, 0, (1.07, .03, 2.94, .63), (1.49, .1, 4.29, .87), (1.97, .44, 5.18, 1.0), None),
    ("hexes, large deformation (Ansys)", HEXES, "green", 0, 0, (1.06, .04, 2.93, .63), (1.45, .05, 4.12, .83), (1.78, .2, 4.83, .91), None),
    ("Phymul", PHYMUL, None, 0, 0, (1.19, .19, 3.30, .54), (1.98, .34, 5.52, .88), (2.69, .33, 6.72, 1.16), 12),
]


def beads(data):
    """Measured places in the model's frame, shape (4, 343, 3) [m]: at rest and at the three compressions."""
    table = np.genfromtxt(os.path.join(data, "truthcube", "uniaxial_positions.csv"), delimiter=",", skip_header=7)
    places = table[:, 3:15].reshape(-1, 4, 3).transpose(1, 0, 2) * np.array([1, 1, -1]) / 1000
    return places - places[0].mean(axis=0)


def interpolate(grid, at):
    """The nodal field `grid`, shape (9^3, 3), x fastest, at the points `at`."""
    field = grid.reshape(CELLS + 1, CELLS + 1, CELLS + 1, 3)
    local = (at / SIZE + 0.5) * CELLS
    cell = np.clip(local.astype(int), 0, CELLS - 1)
    t = local - cell
    value = np.zeros_like(at)
    for corner in range(8):
        bit = np.array([corner & 1, corner >> 1 & 1, corner >> 2])
        weight = np.prod(np.where(bit, t, 1 - t), axis=1)
        i = cell + bit
        value += weight[:, None] * field[i[:, 2], i[:, 1], i[:, 0]]
    return value


def deviation(computed, measured):
    """Mean, min, max, standard deviation [%]; and the mean without the rigid shift."""
    difference = computed - measured
    size = np.linalg.norm(difference, axis=1) / SIZE * 100
    shifted = np.linalg.norm(difference - difference.mean(axis=0), axis=1) / SIZE * 100
    return size.mean(), size.min(), size.max(), size.std(ddof=1), shifted.mean()


def simulate(stroma, row, static):
    name, scene, method, update_b, update_v = row[:5]
    settings = [] if method is None else [FEM + "method=" + method]
    if method is not None and update_b == 0:
        settings.append(FEM + "updateStiffnessMatrix=false")
    if update_v:
        settings.append(FEM + "updateVolume=true")
    if scene == TETS:
        settings = [setting.replace("/fem.", "/cells/fem.") for setting in settings]
    if static:
        return stroma.run(scene + "_static.xml", settings, steps=9, every=3)
    return stroma.run(scene + ".xml", settings, until=9, every=7500)


def run(stroma, data, out, report):
    if not os.path.exists(os.path.join(data, "truthcube")):
        report.append("## Truth cube\n\nSkipped: the measured bead positions are absent.\n")
        return
    measured = beads(data)
    header = ["method", "compression", "mean", "min", "max", "std", "mean, shift removed", "paper mean", "paper min",
              "paper max", "paper std", "ms a step", "paper ms", "end"]
    text = ""
    for static in (False, True):
        rows = []
        for row in ROWS:
            if static and row[1] == PHYMUL:
                continue
            result = simulate(stroma, row, static)
            frames = result["frames"].get("cube.dofs", np.zeros((0, 0, 0)))
            for k, compression in enumerate(COMPRESSIONS):
                paper = list(row[5 + k] or ()) + [None] * 4
                ms = result["summary"].get("ms_per_step", {}).get("median")
                values = ["-"] * 5
                # a run that stopped early has recorded its last good state last: only whole stages count
                whole = len(frames) > k + 1 and (result["code"] == 0 or len(frames) > k + 2)
                if whole:
                    computed = measured[0] + interpolate(frames[k + 1] - frames[0], measured[0])
                    values = [f"{value:.2f}" for value in deviation(computed, measured[k + 1])]
                rows.append([row[0], compression + " %"] + values + ["" if p is None else f"{p:.2f}" for p in paper[:4]] +
                            [f"{ms:.3f}" if ms else "-", row[8] or "", "" if whole else last_line(result)])
            print("  ", row[0], "static" if static else "as in the paper", *[r[2] for r in rows[-3:]], flush=True)
        sr.write_csv(os.path.join(out, "truth_cube_static.csv" if static else "truth_cube.csv"), header, rows)
        title = ("Converged: statics without gravity, one solution a stage" if static else
                 "As in the paper: dynamics, gravity, steps of 0.4 ms, five conjugate gradient iterations")
        text += f"### {title}\n\n" + sr.markdown(header, rows) + "\n"
    report.append("## Truth cube\n\nRelative deviation in percent of 80 mm, 343 beads.\n\n" + text)


def last_line(result):
    return result["message"].splitlines()[-1] if result["message"] else f"exit {result['code']}"
