#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""How contact grows with a sheet that lies on itself: a square sheet, folded in half, on a plane. Both halves touch each other
everywhere, and the lower one the plane. Processor time and memory of a run with contact and of one without it, each in a process of its
own.

  contact_growth.py --triangles 10000 100000
  contact_growth.py --triangles 1000000 --steps 2

Needs the Python package of the build: PYTHONPATH=build/release/python.
"""
import argparse
import json
import resource
import subprocess
import sys
import time

import numpy as np

# Pa, kg, m; each half weighs 1.96 Pa, a tenth of the contact's stiffness
KAPPA, MASS = 19.62, 0.2
SCENE = """<Node name="root" dt="0.01" gravity="0 0 -9.81">
  <EulerImplicitSolver name="solver" newtonIterations="30" newtonTolerance="1e-4" rayleighMass="20"/>
  <CGLinearSolver name="linear" iterations="50" tolerance="1e-4"/>
  <RegularGridTopology name="grid" n="{n} {n} 1" min="0 0 0" max="1 1 0" computeTriangleList="true"/>
  <TriangleSetTopologyContainer name="mesh" position="@grid.position" triangles="@grid.triangles"/>
  <UniformMass name="mass" totalMass="{mass}"/>
  <TriangularFEMForceField name="fem" topology="@mesh" youngModulus="10 Pa" poissonRatio="0.3" thickness="0.001"/>
  {contact}
</Node>"""


def gap_under(pressure):
    """Over contactDistance, where the barrier bears `pressure` over kappa."""
    low, high = 1e-6, 1.0
    for _ in range(60):
        r = (low + high) / 2
        low, high = (r, high) if 2 * (r - 1) * np.log(r) + (r - 1) ** 2 / r > pressure else (low, r)
    return r


def folded(points, distance):
    """The part beyond a slanted line lies upside down on the other one; both are where their weight brings them."""
    along, middle = np.array((0.1, 1.0, 0.0)) / np.hypot(0.1, 1), np.array((0.5, 0.5, 0.0))
    across = np.array((along[1], -along[0], 0.0))
    beyond = (points - middle) @ across
    above = beyond > 0
    points[above] -= 2 * np.outer(beyond[above], across)
    lower = gap_under(2 * MASS * 9.81 / KAPPA) * distance
    points[:, 2] = lower + above * gap_under(MASS * 9.81 / KAPPA) * distance
    return points


def memory():
    """Of this process now [MB]."""
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * resource.getpagesize() / 2**20


def run(triangles, steps, with_contact):
    import stroma  # only the processes that run a scene need it
    n = 2 * round((triangles / 2) ** 0.5 / 2) + 2  # an even number of nodes: the middle is between two of them
    distance = 0.2 / (n - 1)
    barrier = (f'<BarrierContact name="contact" topology="@mesh" contactDistance="{distance}" stiffness="{KAPPA}" planes="0 0 1 0"/>'
               if with_contact else "")
    at = np.linspace(0, 1, n)
    points = folded(np.array([(x, y, 0) for y in at for x in at]), distance)
    scene = stroma.from_xml_text(SCENE.format(n=n, mass=MASS, contact=barrier))
    scene.add("MechanicalObject", name="dofs", position=points, rest_position="@grid.position")
    before, start = memory(), time.process_time()
    simulation = stroma.load(scene, quiet=True)
    first, iterations, times = None, [], []
    for step in range(steps + 1):
        report = simulation.step()
        now = time.process_time()
        if first is None:
            first = now - start
        else:
            times.append(now - last)
            iterations.append((report.newton_iterations, report.linear_iterations))
        last = now
    touching = int(np.count_nonzero(np.array(simulation["/contact"].contactStates))) if with_contact else 0
    return {"triangles": 2 * (n - 1) ** 2, "first": first, "step": min(times), "iterations": iterations[int(np.argmin(times))],
            "memory": memory() - before, "touching": touching, "nodes": n * n, "converged": report.newton_converged}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--triangles", nargs="+", type=int, default=[10000, 100000])
    parser.add_argument("--steps", type=int, default=5)
    parser.add_argument("--child", choices=["contact", "alone"], help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.child:
        print(json.dumps(run(asked.triangles[0], asked.steps, asked.child == "contact")))
        return
    head = ["triangles", "", "load and first step", "fastest of the next", "Newton and linear iterations", "memory", "nodes in contact"]
    print(f"| {' | '.join(head)} |\n{len(head) * '|---'}|")
    for triangles in asked.triangles:
        for kind in ("contact", "alone"):
            result = subprocess.run([sys.executable, __file__, "--triangles", str(triangles), "--steps", str(asked.steps), "--child", kind],
                                    stdout=subprocess.PIPE, check=True)
            r = json.loads(result.stdout)
            newton, linear = r["iterations"]
            print(f"| {r['triangles']} | {kind} | {r['first']:.2f} s | {r['step']:.3g} s | {newton}, {linear} | {r['memory']:.0f} MB | "
                  f"{r['touching']} of {r['nodes']} |{'' if r['converged'] else ' not converged'}", flush=True)


if __name__ == "__main__":
    main()
