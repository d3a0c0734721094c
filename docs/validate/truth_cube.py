# SPDX-License-Identifier: LGPL-2.1-or-later
"""The truth cube: tables 1 to 3 of Nesme et al. 2005 against the measured beads of Kerdok et al. 2003.

The model is centred on the mean of the 343 beads at rest, its z the negative of the data's. A bead's computed place is its
place at rest plus the displacement there, interpolated trilinearly in its cell; the deviation is the distance to the measured
place over 80 mm. "shift removed" takes the mean of the difference vectors out first.
"""
import os

import numpy as np

import stroma_run as sr
import truth_cube_paper as paper
from truth_cube_causes import causes

SIZE = 0.08
COMPRESSIONS = ("5", "12.5", "18.25")
SCENES = {kind: "scenes/validation/truth_cube_" + name
          for kind, name in (("tets", "tetrahedra"), ("hexes", "hexahedra"), ("Phymul", "phymul_volume"),
                             ("Phymul, volume free", "phymul"))}
REST = 0.1  # [%] of the size: a body that moved further in the half second before the measurement is not at rest
LIKE_PAPER = {"until": 9, "every": 1250}  # 19 instants, half a second apart, six to a stage
STATIC_STEPS = 6  # of each stage
VISCOSITY = 0.02  # [s]
STATIC = {"steps": 3 * STATIC_STEPS, "every": 1}


def beads(file):
    """Measured places in the model's frame, shape (4, 343, 3) [m]: at rest and at the three compressions."""
    table = np.genfromtxt(file, delimiter=",", skip_header=7)
    places = table[:, 3:15].reshape(-1, 4, 3).transpose(1, 0, 2) * np.array([1, 1, -1]) / 1000
    return places - places[0].mean(axis=0)


def interpolate(grid, at):
    """The nodal field `grid`, shape (n^3, 3), x fastest, at the points `at`."""
    cells = round(len(grid) ** (1 / 3)) - 1
    field = grid.reshape(cells + 1, cells + 1, cells + 1, 3)
    local = np.clip(at / SIZE + 0.5, 0, 1) * cells
    cell = np.clip(local.astype(int), 0, cells - 1)
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


def settings(row, poisson, dilatation):
    """Overrides for a row of the paper's tables."""
    kind, method, update_b, update_v = row.model
    fem = "/cells/fem." if kind == "tets" else "/fem."
    chosen = [fem + "poissonRatio=" + poisson, fem + "dilatation=" + dilatation] if method else []
    if method:
        chosen.append(fem + "method=" + method)
    if method in ("large", "polar", "svd"):
        chosen += [f"{fem}updateStiffnessMatrix={'true' if update_b else 'false'}",
                   f"{fem}updateVolume={'true' if update_v else 'false'}"]
    elif method:
        chosen.append(fem + "updateStiffnessMatrix=false")
    return chosen


def far(a, b):
    """Largest distance of two shapes in percent of the cube; infinite where one is not finite."""
    distance = np.linalg.norm(a - b, axis=1).max() / SIZE * 100
    return distance if np.isfinite(distance) else np.inf


def verdict(frames, k, equilibrium, result):
    """Why stage k (1 to 3) has no answer, or what is to be said of it; an answer, yes or no."""
    stopped = result["summary"].get("outcome") == "diverged"  # then the last good state is recorded too
    whole = len(frames) > 6 * k + (1 if stopped else 0)
    if not whole:
        return False, "stopped: " + last_line(result)
    here = frames[6 * k]
    if not far(here, frames[0]) < 100:
        return False, "flew apart: a node is more than 80 mm from its place at rest"
    moved = far(here, frames[6 * k - 1])
    if moved > REST:
        return True, f"not at rest: {moved:.1f} % of the size in the last half second"
    if equilibrium is not None and far(here, equilibrium) > 5:
        return True, f"at rest in another shape, {far(here, equilibrium):.0f} % of the size from the converged one"
    return True, ""


def not_solved(result):
    """What a static run says of steps that were not solved, and of elements that turned inside out on the way; or nothing."""
    words = [line for line in result["message"].splitlines() if "Newton" in line or "inverted" in line]
    if result["code"] and not words:
        words = [last_line(result)]
    return "; ".join(word.removeprefix("warning: ") for word in words)


def stage_rows(row, results, measured, equilibria):
    """Lines of the three stages, each read from its own result, and its shapes: None where there is a remark."""
    rows, shapes = [], []
    for k, (compression, result) in enumerate(zip(COMPRESSIONS, results), 1):
        frames = result["frames"].get("cube.dofs", np.zeros((0, 0, 0)))
        equilibrium = equilibria[k - 1] if equilibria else None
        answer, word = verdict(frames, k, equilibrium, result)
        values = ["-"] * 5
        if answer:
            computed = measured[0] + interpolate(frames[6 * k] - frames[0], measured[0])
            values = [f"{value:.2f}" for value in deviation(computed, measured[k])]
        printed = [f"{p:.2f}" for p in row.printed[k - 1]] if row.printed else [""] * 4
        rows.append([row.name, compression + " %"] + values + printed + times(row, result, equilibria is None, k) + [word])
        shapes.append(frames[6 * k] if answer and not word else None)
    return rows, shapes


def times(row, result, static, k):
    """Median of a step beside the paper's in dynamics; of statics all steps of the stages so far, whose times differ."""
    step = result["summary"].get("ms_per_step", {})
    if not step:
        return ["-"] if static else ["-", row.ms or ""]
    return [f"{step['mean'] * STATIC_STEPS * k:.0f}"] if static else [f"{step['median']:.3f}", row.ms or ""]


HEADER = ["method", "compression", "mean", "min", "max", "std", "shift removed", "paper: mean", "min", "max", "std"]
TIMES = {False: ["ms per step", "paper: ms", "remark"], True: ["ms from rest to here", "remark"]}


def table(stroma, measured, body, static, equilibria):
    """Rows of the table; for statics `equilibria` is filled, for dynamics it is what the shapes are compared with."""
    name, poisson, dilatation = body
    rows = []
    for row in paper.ROWS:
        scene = SCENES[row.model[0]]
        if static and "phymul" in scene or dilatation == "mean" and not paper.has_mean_dilatation(row):
            continue
        chosen = settings(row, poisson, dilatation)
        if static:
            results = [stroma.run(scene + "_static.xml", chosen, steps=STATIC_STEPS * k) for k in (1, 2, 3)]
            added, shapes = stage_rows(row, results, measured, None)
            for k, result in enumerate(results):
                if said := not_solved(result):
                    added[k][-1] = "; ".join(word for word in (added[k][-1], said) if word)
                    shapes[k] = None
            equilibria[row.name] = shapes
        else:
            result = stroma.run(scene + ".xml", chosen, **LIKE_PAPER)
            added, _ = stage_rows(row, [result] * 3, measured, equilibria.get(row.name, [None] * 3))
            if not added[-1][-1]:  # what a run says of its end belongs to the last stage
                added[-1][-1] = not_solved(result)
        rows += added
        print("  ", name, "static" if static else "as in the paper", row.name, *[r[2] for r in added], flush=True)
    return rows


def damped(stroma, measured, rows):
    """The rows of the paper's settings that have no answer or are not at rest, with a viscosity of the silicone beside, which
    does not move the equilibrium."""
    again = []
    for row in paper.ROWS:
        if any(line[0] == row.name and line[-1] for line in rows):
            result = stroma.run(SCENES[row.model[0]] + ".xml", settings(row, "0.499", "local") +
                                [f"/solver.rayleighStiffness={VISCOSITY}"], **LIKE_PAPER)
            again += stage_rows(row, [result] * 3, measured, None)[0]
    header = HEADER[:3] + ["remark"]
    return (f"Of these rows, those with a remark once more, with `rayleighStiffness=\"{VISCOSITY}\"` [s]: what five iterations leave "
            "unsolved is damped, and the equilibrium is the same.\n\n" + sr.markdown(header, [line[:3] + [line[-1]] for line in again]) + "\n")


def last_line(result):
    return result["message"].splitlines()[-1] if result["message"] else f"exit {result['code']}"


TITLES = {
    False: "As in the paper, Poisson's ratio {}: dynamics, gravity, steps of 0.4 ms, five conjugate gradient iterations",
    True: "Converged, Poisson's ratio {}: statics without gravity",
}
FILES = {False: "truth_cube_{}.csv", True: "truth_cube_static_{}.csv"}


def run(stroma, out, report):
    file = stroma.shared_file("truthcube", "uniaxial_positions.csv")
    if file is None:
        print("   skipped: the measured bead positions are absent, see --data", flush=True)
        report.append("## Truth cube\n\nSkipped: the measured bead positions are absent.\n")
        return
    measured = beads(file)
    text, tables = {}, {}
    for body in paper.BODIES:
        equilibria, name = {}, body[0]
        for static in (True, False):
            rows = table(stroma, measured, body, static, equilibria)
            header = HEADER + TIMES[static]
            sr.write_csv(os.path.join(out, FILES[static].format(name.replace(" ", "_"))), header, rows)
            tables[name, static] = rows
            text[name, static] = f"### {TITLES[static].format(name)}\n\n" + sr.markdown(header, rows) + "\n"
    text["0.499", False] += damped(stroma, measured, tables["0.499", False])
    why = causes(stroma, measured, out, tables)
    report.append("## Truth cube\n\n" + paper.INTRODUCTION + "\n" +
                  "".join(text[body[0], static] for body in paper.BODIES for static in (False, True)) + why)
