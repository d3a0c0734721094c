#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""A linear cube under its weight by Stroma and by CalculiX (Debian's calculix-ccx): the same tetrahedra, forces and held nodes.

    tools/bench/calculix_cube.py --nodes 22 --rounds 2 --stroma build/release/bin/stroma

Prints processor seconds of whole commands on one thread, in turns, and the largest displacement."""
import argparse
import json
import math
import os
import resource
import shlex
import subprocess
import tempfile

STROMA = {"nothing named": "", "SparseLDLSolver": '<SparseLDLSolver name="linear"/>'}
CALCULIX = {"CalculiX, SPOOLES": "SPOOLES", "CalculiX, iterative with incomplete Cholesky": "ITERATIVE CHOLESKY"}
CUTS = (((0, 1, 2, 4), (3, 1, 2, 7), (5, 1, 4, 7), (6, 2, 4, 7), (1, 2, 4, 7)),
        ((1, 0, 3, 5), (2, 0, 3, 6), (4, 0, 5, 6), (7, 3, 5, 6), (0, 3, 5, 6)))


def volume(a, b, c, d):
    u, v, w = ([q - p for p, q in zip(a, x)] for x in (b, c, d))
    return (u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0]))


def cube(n):
    """Places and tetrahedra, five in each cell, of 0.1 m."""
    edge = [.1 * i / (n - 1) for i in range(n)]
    points = [(x, y, z) for z in edge for y in edge for x in edge]
    cells = []
    for i, j, k in ((i, j, k) for k in range(n - 1) for j in range(n - 1) for i in range(n - 1)):
        corners = [i + (b & 1) + n * (j + (b >> 1 & 1) + n * (k + (b >> 2 & 1))) for b in range(8)]
        for cut in CUTS[(i + j + k) % 2]:
            a, b, c, d = (corners[x] for x in cut)
            cells.append((a, b, c, d) if volume(*(points[x] for x in (a, b, c, d))) > 0 else (b, a, c, d))
    return points, cells


def write(folder, points, cells):
    wall = [i for i, p in enumerate(points) if p[0] < 1e-9]
    places, corners = (" ".join(f"{x:.9g}" for row in rows for x in row) for rows in (points, cells))
    for name, solver in STROMA.items():
        with open(os.path.join(folder, name + ".xml"), "w") as out:
            out.write(f'<Node name="root" gravity="0 -9.81 0" dt="1"><StaticSolver name="solver"/>{solver}<MeshTopology '
                      f'name="mesh" position="{places}" tetrahedra="{corners}"/><MechanicalObject name="dofs"/>'
                      '<DiagonalMass massDensity="1000"/>'
                      '<TetrahedronFEMForceField name="fem" youngModulus="1e7" poissonRatio="0.3" method="small"/>'
                      f'<FixedProjectiveConstraint name="held" indices="{" ".join(map(str, wall))}"/></Node>')
    for name, solver in CALCULIX.items():
        with open(os.path.join(folder, solver[:4] + ".inp"), "w") as out:
            out.write("*NODE,NSET=ALL\n" + "".join(f"{i + 1},{x:.9g},{y:.9g},{z:.9g}\n" for i, (x, y, z) in enumerate(points)))
            out.write("*ELEMENT,TYPE=C3D4,ELSET=E\n")
            out.write("".join(f"{e + 1}," + ",".join(str(i + 1) for i in cell) + "\n" for e, cell in enumerate(cells)))
            out.write("*BOUNDARY\n" + "".join(f"{i + 1},1,3\n" for i in wall))
            out.write("*MATERIAL,NAME=M\n*ELASTIC\n1e7,0.3\n*DENSITY\n1000\n*SOLID SECTION,ELSET=E,MATERIAL=M\n*STEP\n"
                      f"*STATIC,SOLVER={solver}\n*DLOAD\nE,GRAV,9.81,0,-1,0\n*NODE PRINT,NSET=ALL\nU\n*END STEP\n")


def seconds(command, folder):
    """Processor time, and what was written."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    one_thread = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, cwd=folder, env=one_thread, capture_output=True, text=True, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done.stdout


def largest(file):
    rows = [line.split() for line in open(file)]
    return max(math.hypot(*map(float, r[1:])) for r in rows if len(r) == 4 and r[0].isdigit())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--nodes", type=int, default=22, help="along an edge")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--stroma", default="stroma", metavar="COMMAND")
    asked = parser.parse_args()
    stroma = shlex.split(asked.stroma)
    stroma[0] = os.path.abspath(stroma[0]) if os.sep in stroma[0] else stroma[0]
    found = {name: [] for name in (*STROMA, *CALCULIX)}
    displacement = {}
    with tempfile.TemporaryDirectory() as folder:
        points, cells = cube(asked.nodes)
        write(folder, points, cells)
        for _ in range(asked.rounds):
            for name in STROMA:
                options = ["-n", "1", "--no-record", "--threads", "1", "--quiet", "--json", "-"]
                time, text = seconds([*stroma, "run", name + ".xml", *options], folder)
                found[name].append(time)
                displacement[name] = json.loads(text[text.index("{"):])["greatest_displacements"][0]["distance"]
            for name, solver in CALCULIX.items():
                found[name].append(seconds(["ccx", solver[:4]], folder)[0])
                displacement[name] = largest(os.path.join(folder, solver[:4] + ".dat"))
    print(f"{len(points)} nodes, {len(cells)} tetrahedra")
    for name, times in found.items():
        print(f"| {name} | {min(times):.2f} | {displacement[name]:.5g} |")


if __name__ == "__main__":
    main()
