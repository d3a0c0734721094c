#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""A beam of soft tissue that bends under its weight, built in Python. Run it with: python3 scenes/python/first_scene.py"""
import stroma

root = stroma.Node("root", dt=0.01, gravity=(0, -9.81, 0))
root.add("EulerImplicitSolver", rayleighStiffness=0.02)
root.add("CGLinearSolver", iterations=500, tolerance=1e-8)

beam = root.add_child("beam")
beam.add("RegularGridTopology", n=(13, 4, 4), min=(0, 0, 0), max=(0.24, 0.06, 0.06))
beam.add("MechanicalObject", name="dofs")
beam.add("UniformMass", totalMass=0.9)
beam.add("HexahedronFEMForceField", name="fem", youngModulus="200 kPa", poissonRatio=0.45, method="polar")
end = beam.add("BoxROI", name="end", box=(-0.001, -1, -1, 0.001, 1, 1))
beam.add("FixedProjectiveConstraint", indices=end.link("indices"))
print(f"{len(end.indices)} nodes are held")  # the region has found them already

simulation = stroma.load(root)
x = simulation.state("/beam").x  # a view: it follows the steps
for _ in range(5):
    simulation.run(20)
    print(f"t = {simulation.time:.1f} s: the tip is at y = {x[:, 1].min() * 1000:.1f} mm")


def check():
    assert -0.1 < x[:, 1].min() < -0.005
