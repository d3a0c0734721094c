#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Control by a function that is called before each step: the stiffness of a beam is changed until its tip hangs where it should, and
the run is stopped there. Run it with: python3 scenes/python/control.py"""
import stroma

WANTED = -0.03  # [m], the tip's y

simulation = stroma.load(stroma.from_xml_text("""<Node name="root" dt="0.02" gravity="0 -9.81 0">
  <EulerImplicitSolver rayleighStiffness="0.1" rayleighMass="2"/> <CGLinearSolver iterations="300" tolerance="1e-8"/>
  <RegularGridTopology n="9 3 3" min="0 0 0" max="0.16 0.04 0.04"/> <MechanicalObject name="dofs"/> <UniformMass totalMass="0.3"/>
  <HexahedronFEMForceField name="fem" youngModulus="200000" poissonRatio="0.3" method="polar"/>
  <BoxROI name="end" box="-0.001 -1 -1 0.001 1 1"/> <FixedProjectiveConstraint indices="@end.indices"/> </Node>"""))
fem, x = simulation["/fem"], simulation.state().x
young = 200000.0


def control(sim):
    global young
    if sim.steps % 5 == 0 and sim.steps > 20:
        too_low = (WANTED - x[:, 1].min()) / abs(WANTED)
        young *= 1 + 0.15 * min(max(too_low, -1), 1)
        fem.youngModulus = young


def is_there(sim):
    if sim.steps > 50 and abs(x[:, 1].min() - WANTED) < 2e-4 and abs(sim.state().v).max() < 0.005:
        sim.stop("the tip is where it should be")


simulation.on_step_begin(control)
simulation.on_step_end(is_there)
simulation.run(steps=2000)
print(f"after {simulation.steps} steps: {simulation.stop_reason or 'not there yet'}")
print(f"y = {x[:, 1].min() * 1000:.2f} mm with a Young's modulus of {young / 1000:.1f} kPa")


def check():
    assert simulation.stop_reason
