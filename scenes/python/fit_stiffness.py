#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Young's modulus from a measured displacement, in ten lines: how far a block of tissue sags under its weight. What is measured
is made here, with 7 kPa; the fit does not see that. Run it with: python3 scenes/python/fit_stiffness.py"""
import numpy
import stroma
from scipy.optimize import least_squares

SCENE = """<Node name="root" dt="1" gravity="0 -9.81 0"> <StaticSolver newton_iterations="30"/> <SparseLDLSolver/>
  <RegularGridTopology n="5 5 4" min="0 0 0" max="0.1 0.1 0.08"/> <MechanicalObject name="dofs"/> <UniformMass totalMass="0.8"/>
  <HexahedronFEMForceField name="fem" youngModulus="5000" poissonRatio="0.4" method="polar"/>
  <BoxROI name="top" box="-1 0.099 -1 1 0.101 1"/> <FixedProjectiveConstraint indices="@top.indices"/> </Node>"""
simulation = stroma.load(stroma.from_xml_text(SCENE))
state, fem = simulation.state(), simulation["/fem"]


def sagged(young):
    simulation.reset()
    fem.youngModulus = float(young)
    simulation.step()
    return state.x.copy()


measured = sagged(7000) + numpy.random.default_rng(1).normal(scale=2e-5, size=(state.nodes, 3))  # 0.02 mm of noise
fit = least_squares(lambda p: ((sagged(p[0] * 1000) - measured) * 1000).ravel(), x0=[2.0])
print(f"Young's modulus {fit.x[0]:.2f} kPa, after {fit.nfev} evaluations")


def check():
    assert abs(fit.x[0] - 7) < 0.05
