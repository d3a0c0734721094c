#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Measure what condensation makes of the mass inside: CondensedDynamicSolver, interiorMass shared and neglected, against the
whole body with the same step.

  docs/validate/condensed_mass.py --stroma build/release/bin/stroma

A cube of tetrahedra held at its floor, three loads that set in at once, two time steps. Prints the table of docs/validation.md.
"""
import argparse
import glob
import math
import os
import subprocess
import tempfile

N = 9  # nodes on an edge
LOADS = {
    "force on one node of the top": '<ConstantForceField indices="{corner}" totalForce="0.05 0.02 0.1"/>',
    "shear on all nodes of the top": '<ConstantForceField indices="{top}" totalForce="0.2 0.08 0"/>',
    "gravity across": "",
}
STEPS = ((0.002, 150), (0.01, 60))


def node(i, j, k):
    return i + N * (j + N * k)


def words(numbers):
    return " ".join(map(str, numbers))


def scene(attributes, load, dt, out):
    gravity = "0 0 0" if LOADS[load] else "0 -9.81 0"
    force = LOADS[load].format(corner=node(N - 1, N // 2, N - 1), top=words(range(N * N * (N - 1), N**3)))
    return f"""<Node name="root" dt="{dt}" gravity="{gravity}"><CondensedDynamicSolver {attributes}/>
<Node name="source"><RegularGridTopology name="grid" n="{N} {N} {N}" min="0 0 0" max="0.1 0.1 0.1"/></Node>
<Node name="body"><TetrahedronSetTopologyContainer name="cells"/>
<Hexa2TetraTopologicalMapping input="@../source/grid" output="@cells"/><MechanicalObject name="dofs"/>
<DiagonalMass massDensity="1000"/>
<TetrahedronFEMForceField name="fem" method="small" youngModulus="5000" poissonRatio="0.45"/>
<FixedProjectiveConstraint indices="{words(range(N * N))}"/>{force}
<WriteState filename="{out}" period="{dt}" writeX="true"/></Node></Node>"""


def positions(stroma, attributes, load, dt, steps):
    """Positions of all nodes in each step, lists of 3 N^3 numbers [m]."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "cube.xml")
        with open(path, "w") as file:
            file.write(scene(attributes, load, dt, os.path.join(folder, "motion")))
        result = subprocess.run([stroma, "run", path, "-n", str(steps), "--quiet", "--no-record"], capture_output=True,
                                text=True)
        if result.returncode not in (0, 3):
            raise RuntimeError(result.stderr)
        with open(glob.glob(os.path.join(folder, "motion*"))[0]) as file:
            lines = [line.split() for line in file]
    return [list(map(float, w[w.index("=") + 1 if "=" in w else 1:])) for w in lines if w and w[0].startswith("X")]


def lengths(a, b):
    return [math.dist(x[k:k + 3], y[k:k + 3]) for x, y in zip(a, b) for k in range(0, len(x), 3)]


def rms(numbers):
    return math.sqrt(sum(v * v for v in numbers) / len(numbers))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stroma", required=True, help="the command")
    stroma = parser.parse_args().stroma
    print("| load | dt (ms) | shared, largest | shared, rms | neglected, largest | neglected, rms |\n|---|---|---|---|---|---|")
    inside = range(1, N - 1)
    surface = [node(i, j, k) for k in range(1, N) for j in range(N) for i in range(N)
               if not (i in inside and j in inside and k < N - 1)]
    for load in LOADS:
        for dt, steps in STEPS:
            whole = positions(stroma, 'condensed="false"', load, dt, steps)
            moved = lengths(whole, [whole[0]] * len(whole))
            row = []
            for mass in ("shared", "neglected"):
                attributes = f'surfaceIndices="{words(surface)}" interiorMass="{mass}"'
                error = lengths(positions(stroma, attributes, load, dt, steps), whole)
                row += [100 * max(error) / max(moved), 100 * rms(error) / rms(moved)]
            print(f"| {load} | {1000 * dt:g} | " + " | ".join(f"{share:.1f} %" for share in row) + " |", flush=True)


if __name__ == "__main__":
    main()
