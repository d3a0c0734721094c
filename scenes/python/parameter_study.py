#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""A study of parameters: how far a beam sags for several moduli and Poisson's ratios, in two threads. Elasticity says that the
deflection of a slender beam goes with 1/E. Run it with: python3 scenes/python/parameter_study.py"""
import stroma

SCENE = """<Node name="root" dt="1" gravity="0 -9.81 0"> <StaticSolver newton_iterations="30"/> <SparseLDLSolver/>
  <RegularGridTopology n="13 3 3" min="0 0 0" max="0.24 0.03 0.03"/> <MechanicalObject name="dofs"/> <UniformMass totalMass="0.2"/>
  <HexahedronFEMForceField name="fem" poissonRatio="0.3" youngModulus="1e6" method="polar"/>
  <BoxROI name="end" box="-0.001 -1 -1 0.001 1 1"/> <FixedProjectiveConstraint indices="@end.indices"/> </Node>"""


def deflection(simulation):
    simulation.step()
    return float(-simulation.state().x[:, 1].min())


runs = stroma.sweep(stroma.from_xml_text(SCENE), {"/fem.youngModulus": ["1 MPa", "2 MPa", "4 MPa"], "/fem.poissonRatio": [0.1, 0.3]},
                    deflection, threads=2)
for run in runs:
    print(", ".join(f"{name.rpartition('.')[2]} {value}" for name, value in run.values.items()), f": {run.result * 1000:.2f} mm")


def check():
    assert not any(run.error for run in runs)
    for softer, stiffer in zip(runs, runs[2:]):
        assert abs(softer.result / stiffer.result / 2 - 1) < 0.1
