#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The truth cube as an inverse problem: Poisson's ratio of a silicone cube from 343 beads that a scanner has seen inside it,
compressed by 5, 12.5 and 18.25 % (Kerdok et al. 2003). The rigid shift between two scans is taken out. Young's modulus cannot be
found from them: a plate moves the top, no force is measured, and without gravity the displacements of an elastic body do not
depend on it. The script shows that by what ten percent of it do to the beads.
Run it with: python3 scenes/python/truth_cube_fit.py [FILE.csv]"""
import os
import sys

import numpy
import stroma
from scipy.optimize import least_squares

SIZE, CELLS, STRAINS = 0.08, 8, (0.05, 0.125, 0.1825)
given = sys.argv[1] if len(sys.argv) > 1 and sys.argv[1].endswith(".csv") else ""
FILE = given or os.path.join(os.environ.get("STROMA_SHARED_DATA", ""), "truthcube", "uniaxial_positions.csv")
if not os.path.exists(FILE):
    print("the measured beads are not here: name the file")
    sys.exit(77)

table = numpy.genfromtxt(FILE, delimiter=",", skip_header=7)
beads = table[:, 3:15].reshape(-1, 4, 3).transpose(1, 0, 2) * (1, 1, -1) / 1000  # [m], z upwards
beads -= beads[0].mean(axis=0)


def cube():
    """Held below, and a plate that goes down by 5 % of the height per 0.05 s of the scene's time."""
    half = SIZE / 2
    root = stroma.Node("root", dt=STRAINS[0] / 2, gravity=(0, 0, 0))
    root.add("StaticSolver", newton_iterations=40, relative_residual_tolerance_threshold=1e-7)
    root.add("SparseLDLSolver")
    root.add("RegularGridTopology", name="grid", n=[CELLS + 1] * 3, min=[-half] * 3, max=[half] * 3)
    root.add("MechanicalObject", name="dofs")
    root.add("UniformMass", totalMass=0.5)
    root.add("HexahedronFEMForceField", name="fem", youngModulus=14900, poissonRatio=0.45, method="polar", dilatation="mean")
    low, top = (root.add("BoxROI", name=name, box=[-1, -1, z - 1e-3, 1, 1, z + 1e-3]) for name, z in (("low", -half), ("top", half)))
    root.add("FixedProjectiveConstraint", indices=low.link("indices"))
    root.add("LinearMovementProjectiveConstraint", indices=top.link("indices"), keyTimes=[0, 1], movements=[[0, 0, 0], [0, 0, -SIZE]])
    return root


def weights():
    """Which nodes a bead lies between: trilinear, in its cell at rest."""
    local = numpy.clip(beads[0] / SIZE + 0.5, 0, 1) * CELLS
    cell = numpy.clip(local.astype(int), 0, CELLS - 1)
    t, found = local - cell, []
    for corner in range(8):
        bit = numpy.array([corner & 1, corner >> 1 & 1, corner >> 2])
        i = cell + bit
        found.append(((i[:, 2] * (CELLS + 1) + i[:, 1]) * (CELLS + 1) + i[:, 0], numpy.prod(numpy.where(bit, t, 1 - t), axis=1)))
    return found


simulation = stroma.load(cube())
state, fem, near = simulation.state(), simulation["/fem"], weights()


def places(young, poisson):
    """Of the beads at each compression, (3, 343, 3) [m]."""
    simulation.reset()
    fem.youngModulus, fem.poissonRatio = float(young), float(poisson)
    found = []
    for strain in STRAINS:
        simulation.run(until=strain)
        moved = state.x - state.start
        found.append(beads[0] + sum(weight[:, None] * moved[nodes] for nodes, weight in near))
    return numpy.array(found)


def residual(poisson):
    """[% of the size], without the shift of the whole cube between two scans."""
    away = (places(14900, poisson) - beads[1:]) / SIZE * 100
    return (away - away.mean(axis=1, keepdims=True)).ravel()


fit = least_squares(lambda p: residual(p[0]), x0=[0.40], bounds=([0.2], [0.499]), diff_step=1e-3, xtol=1e-3, ftol=1e-4)
poisson = float(fit.x[0])
deviations = numpy.linalg.norm(fit.fun.reshape(3, -1, 3), axis=2).mean(axis=1)
of_young = numpy.abs(places(14900 * 1.1, poisson) - places(14900, poisson)).max() / SIZE * 100
of_poisson = numpy.abs(places(14900, poisson - 0.02) - places(14900, poisson)).max() / SIZE * 100
words = ", ".join(f"{d:.2f} %" for d in deviations)
print(f"Poisson's ratio {poisson:.3f}: mean deviation {words} of the size, {fit.nfev} evaluations")
print("at other ratios: " + ", ".join(f"{ratio} {numpy.linalg.norm(residual(ratio).reshape(-1, 3), axis=1).mean():.2f} %"
                                      for ratio in (0.4, 0.45, 0.48)))
print(f"ten percent of E move no bead by more than {of_young:.1e} % of the size, 0.02 of Poisson's ratio move one by {of_poisson:.2f} %")


def check():
    assert 0.42 < poisson <= 0.499
    assert deviations.max() < 1.5
    assert of_young < 1e-4 < 0.05 < of_poisson
