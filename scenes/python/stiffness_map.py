#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Where a block is stiff, from how it deforms: Young's modulus of each cell, found by the gradient of the misfit. Elastography in small. Run it with:
python3 scenes/python/stiffness_map.py"""
import numpy
from scipy.optimize import minimize

import stroma

SOFT, STIFF = 10e3, 30e3  # [Pa]


def pressed_block(modulus):
    """A block of 6 x 6 x 2 cells on a plate, pressed from above, with a modulus for each cell."""
    root = stroma.Node("root", gravity=(0, 0, 0))
    root.add("StaticSolver", newton_iterations=50, relative_residual_tolerance_threshold=1e-11)
    root.add("SparseLDLSolver")
    block = root.add_child("block")
    block.add("RegularGridTopology", name="grid", n=(7, 7, 3), min=(0, 0, 0), max=(0.06, 0.06, 0.02))
    block.add("MechanicalObject", name="dofs")
    block.add("UniformMass", totalMass=0.07)
    block.add("HexahedronFEMForceField", name="fem", youngModulus=modulus, poissonRatio=0.3, method="polar")
    block.add("BoxROI", name="bottom", box=(-1, -0.0001, -1, 1, 0.0001, 1))
    block.add("FixedProjectiveConstraint", indices="@bottom.indices")
    block.add("BoxROI", name="top", box=(-1, 0.0599, -1, 1, 0.0601, 1))
    block.add("ConstantForceField", indices="@top.indices", totalForce=(0.1, -0.2, 0))
    return root


truth = numpy.full((2, 6, 6), SOFT)  # z, y, x: as the cells of a grid follow each other
truth[:, 2:4, 1:4] = STIFF
real = stroma.load(pressed_block(truth.ravel()), quiet=True)
real.run(1)
measured = numpy.array(real.state().x)

simulation = stroma.load(pressed_block(numpy.full(72, SOFT)), quiet=True)
fem = simulation["/block/fem"]
scale = 1 / (numpy.linalg.norm(measured - simulation.state().start) ** 2)


def misfit(logarithms):
    """How far it is from what was measured, and the derivative: moduli are kept above zero by their logarithms."""
    modulus = SOFT * numpy.exp(logarithms)
    fem.youngModulus = modulus
    simulation.run(1)
    off = simulation.state().x - measured
    slope = simulation.gradient(2 * scale * off, "/block/fem.youngModulus").parameters["/block/fem.youngModulus"]
    return scale * (off ** 2).sum(), slope * modulus


found = minimize(misfit, numpy.zeros(72), jac=True, method="L-BFGS-B", bounds=[(-1, 2)] * 72,
                 options={"maxiter": 60, "ftol": 1e-14, "gtol": 1e-9})
modulus = SOFT * numpy.exp(found.x).reshape(truth.shape)
inside = truth == STIFF
print(f"after {found.nfev} tries: {modulus[inside].mean() / 1e3:.1f} kPa inside, {modulus[~inside].mean() / 1e3:.1f} kPa around it")


def check():
    assert abs(modulus[inside].mean() / STIFF - 1) < 0.1 and abs(modulus[~inside].mean() / SOFT - 1) < 0.1
