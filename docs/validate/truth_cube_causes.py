# SPDX-License-Identifier: LGPL-2.1-or-later
"""What moves the numbers of the truth cube: one thing is varied at a time, in statics without gravity."""
import os

import numpy as np

import stroma_run as sr
import truth_cube
import truth_cube_conclusion as conclusion

TETS, HEXES = "scenes/validation/truth_cube_tetrahedra_static.xml", "scenes/validation/truth_cube_hexahedra_static.xml"
LAWS = "scenes/validation/truth_cube_hexahedra_hyperelastic_static.xml"
FEM = "/cells/fem."
HEADER = ["varied", "mean at 5 %", "12.5 %", "18.25 %", "std at 18.25 %", "max at 18.25 %", "remark"]

# name, scene, overrides; the first is what all others differ from
RUNS = [(conclusion.BASE, TETS, [])]
RUNS += [(f"Poisson's ratio {nu}", TETS, [FEM + "poissonRatio=" + nu])
         for nu in ("0.45", "0.47", "0.48", "0.49", "0.495", "0.4999")]
RUNS += [(f"{n} x {n} x {n} cells", TETS, [f"/cube/grid.n={n + 1} {n + 1} {n + 1}"]) for n in (6, 10, 12)]
RUNS += [("five tetrahedra per cell", TETS, ["/cells/cut.cutting=five"]),
         ("six tetrahedra per cell", TETS, ["/cells/cut.cutting=six"]),
         ("gravity", TETS, ["/.gravity=0 0 -9.81"]),
         ("gravity, Poisson's ratio 0.48", TETS, [FEM + "poissonRatio=0.48", "/.gravity=0 0 -9.81"]),
         ("the top slides on its plate", TETS, ["/cube/plate.movedDirections=0 0 1"]),
         ("the base slides", TETS, ["/cube/glued.fixedDirections=0 0 1"]),
         ("hexes, polar, no B, Poisson's ratio 0", HEXES,
          ["/fem.method=polar", "/fem.updateStiffnessMatrix=false", "/fem.poissonRatio=0"]),
         (conclusion.LOGARITHMIC, LAWS, []),
         (conclusion.LOGARITHMIC + ", Poisson's ratio 0.48", LAWS, ["/fem.poissonRatio=0.48"]),
         ("hexes, neo-Hookean law, mean dilatation", LAWS, ["/fem.materialName=NeoHookean", "/fem.alpha1="])]


def registrations(frames, measured):
    """Other ways to lay the model over the beads: name and computed minus measured places at each stage."""
    rest, stages = measured[0], range(1, 4)
    moved = [frames[6 * k] - frames[0] for k in stages]
    ideal = np.round(rest / 0.01) * 0.01
    at = truth_cube.interpolate
    for name, shift in (("the cube 0.5 mm lower", (0, 0, .0005)), ("the cube 0.5 mm higher", (0, 0, -.0005)),
                        ("the cube 1 mm aside", (.001, 0, 0))):
        yield name, [rest + at(moved[k - 1], rest + shift) - measured[k] for k in stages]
    yield "displacement at the beads' nominal places", [rest + at(moved[k - 1], ideal) - measured[k] for k in stages]
    yield "beads taken to start at their nominal places", [ideal + at(moved[k - 1], ideal) - measured[k] for k in stages]
    differences = [rest + at(moved[k - 1], rest) - measured[k] for k in stages]
    yield "rigid shift removed at each stage", [d - d.mean(axis=0) for d in differences]


def line(name, differences, remark=""):
    sizes = [np.linalg.norm(d, axis=1) / truth_cube.SIZE * 100 for d in differences]
    return ([name] + [f"{size.mean():.2f}" for size in sizes] + [f"{sizes[-1].std(ddof=1):.2f}", f"{sizes[-1].max():.2f}", remark])


def affine(measured):
    """The plate's travel spread evenly over the height, without any bulge."""
    rest = measured[0]
    down = (rest[:, 2] / truth_cube.SIZE + 0.5)[:, None] * np.array([0, 0, -1.])
    return [rest + travel * down - measured[k] for k, travel in enumerate((.004, .01, .0146), 1)]


def causes(stroma, measured, out, tables):
    """The text of the section; `tables`: the rows of the tables above, by Poisson's ratio and statics or not."""
    rows = []
    for name, scene, overrides in RUNS:
        result = stroma.run(scene, overrides, **truth_cube.STATIC)
        frames = result["frames"].get("cube.dofs", np.zeros((0, 0, 0)))
        if len(frames) < 19:
            rows.append([name] + ["-"] * 5 + [truth_cube.last_line(result)])
            continue
        rest = measured[0]
        rows.append(line(name, [rest + truth_cube.interpolate(frames[6 * k] - frames[0], rest) - measured[k] for k in (1, 2, 3)],
                         truth_cube.not_solved(result)))
        if name == RUNS[0][0]:
            rows += [line(*registration) for registration in registrations(frames, measured)]
        print("   varied:", *rows[-1], flush=True)
    rows.append(line(conclusion.NO_MODEL, affine(measured)))
    for row in truth_cube.paper.ROWS:
        if row.name in (conclusion.BASE, conclusion.HEXES):
            means = [stage[0] for stage in row.printed]
            rows.append(["paper: " + row.name, *means, row.printed[-1][3], row.printed[-1][2], ""])
    sr.write_csv(os.path.join(out, "truth_cube_causes.csv"), HEADER, rows)
    return "### What explains the differences\n\n" + sr.markdown(HEADER, rows) + "\n" + conclusion.conclusion(tables, rows)
