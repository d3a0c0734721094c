#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""A bar of 41,472 tetrahedra whose ends are turned against each other, two turns a second, until it touches itself: processor time and
iterations of each step. Run it with: python3 docs/contact/twisted_bar.py [STEPS]"""
import sys
import time

import numpy
import stroma

ACROSS, ALONG, TURNS, SECONDS = 13, 49, 3, 1.5  # nodes; turns in that time

SCENE = """<Node name="root" dt="0.01" gravity="0 0 0">
  <EulerImplicitSolver name="solver" newtonIterations="30" newtonTolerance="1e-3" rayleighMass="2" rayleighStiffness="0.01"/>
  <RegularGridTopology name="grid" n="{across} {across} {along}" min="-0.02 -0.02 0" max="0.02 0.02 0.2"/>
  <MechanicalObject name="dofs"/>
  <UniformMass name="mass" totalMass="0.32"/>
  {ends}
  <Node name="cells">
    <TetrahedronSetTopologyContainer name="mesh"/>
    <Hexa2TetraTopologicalMapping name="cut" input="@../grid" output="@mesh"/>
    <TetrahedronFEMForceField name="fem" mstate="@../dofs" topology="@mesh" youngModulus="100 kPa" poissonRatio="0.3" method="svd"/>
  </Node>
  <BarrierContact name="contact" topology="@cells/mesh" contactDistance="1 mm" stiffness="100 kPa"/>
</Node>"""


def turned(node, x, y, way):
    """A node of an end, on 24 straight parts a turn."""
    keys = numpy.linspace(0, SECONDS, 24 * TURNS + 1)
    angles = way * numpy.pi * TURNS * keys / SECONDS
    c, s = numpy.cos(angles), numpy.sin(angles)
    moves = " ".join(f"{u:.6g} {v:.6g} 0" for u, v in zip(c * x - s * y - x, s * x + c * y - y))
    times = " ".join(f"{key:.6g}" for key in keys)
    return f'<LinearMovementProjectiveConstraint indices="{node}" keyTimes="{times}" movements="{moves}" outside="hold"/>'


at = numpy.linspace(-0.02, 0.02, ACROSS)
ends = [turned(i + ACROSS * (j + ACROSS * layer), at[i], at[j], way) for layer, way in ((0, -1), (ALONG - 1, 1))
        for j in range(ACROSS) for i in range(ACROSS)]
simulation = stroma.load(stroma.from_xml_text(SCENE.format(across=ACROSS, along=ALONG, ends="\n  ".join(ends))))
contact = simulation["/contact"]
for step in range(1, int(sys.argv[1]) + 1 if len(sys.argv) > 1 else 99):
    start = time.process_time()
    report = simulation.step()
    seconds = time.process_time() - start
    print(f"step {step}: {seconds:.3f} s, {report.newton_iterations} iterations, smallest gap {contact.smallestGap:.2g} m", flush=True)
