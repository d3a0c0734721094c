#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Pairs of bodies that fly into each other, at random: shapes, places, velocities, moduli, steps of 1 to 25 ms. After every step
the contact's exact test of all edges against all triangles must have found nothing, and every number must be one. Usage:
  contact_drops.py [--stroma build/release/bin/stroma] [--pairs 10000] [--seed 1]
Prints how many were clean; the first scene that was not is kept and named, and the exit code is 1."""
import argparse
import os
import random
import subprocess
import sys
import tempfile
import time

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
CUBE = ([(i & 1, i >> 1 & 1, i >> 2) for i in range(8)],
        [(0, a, a | b, 7) for a, b in ((1, 2), (1, 4), (2, 1), (2, 4), (4, 1), (4, 2))])
SPIKE = ([(-.5, 0, -.5), (.5, 0, -.5), (.5, 0, .5), (-.5, 0, .5), (0, 3, 0)], [(0, 1, 2, 4), (0, 2, 3, 4)])
WEDGE = ([(-.5, 0, -1), (.5, 0, -1), (0, 3, -1), (-.5, 0, 1), (.5, 0, 1), (0, 3, 1)], [(0, 1, 2, 3), (1, 2, 3, 4), (2, 3, 4, 5)])


def volume(points, cell):
    a, b, c, d = (points[i] for i in cell)
    u, v, w = ([q[k] - a[k] for k in range(3)] for q in (b, c, d))
    return (u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) + u[2] * (v[0] * w[1] - v[1] * w[0])) / 6


def rotated(points):
    """By a random rotation, from a random quaternion."""
    q = [random.gauss(0, 1) for _ in range(4)]
    size = sum(c * c for c in q) ** 0.5
    w, x, y, z = (c / size for c in q)
    rows = [(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y))]
    return [tuple(sum(r[k] * p[k] for k in range(3)) for r in rows) for p in points]


def body():
    kind = random.choice(["tetrahedron", "box", "plate", "needle", "spike", "wedge"])
    if kind == "tetrahedron":
        while True:
            points, cells = [tuple(random.uniform(-1, 1) for _ in range(3)) for _ in range(4)], [(0, 1, 2, 3)]
            if abs(volume(points, cells[0])) > 0.03:
                break
    elif kind in ("spike", "wedge"):
        points, cells = SPIKE if kind == "spike" else WEDGE
    else:
        size = {"box": (1, 1, 1), "plate": (1.5, 1.5, 0.1), "needle": (0.1, 0.1, 2)}[kind]
        points, cells = [tuple(p[k] * size[k] for k in range(3)) for p in CUBE[0]], CUBE[1]
    points = rotated(points)
    return points, [c if volume(points, c) > 0 else (c[1], c[0], c[2], c[3]) for c in cells]


def pair(name):
    """The second starts 0.03 above the first and comes down on it."""
    (low, cells), (high, others) = body(), body()
    top, bottom = max(p[2] for p in low), min(p[2] for p in high)
    at_top, at_bottom = max(low, key=lambda p: p[2]), min(high, key=lambda p: p[2])
    aside = [at_top[k] - at_bottom[k] + random.uniform(-.2, .2) for k in range(2)]
    high = [(p[0] + aside[0], p[1] + aside[1], p[2] - bottom + top + 0.03) for p in high]
    velocity = [random.uniform(-2, 2), random.uniform(-2, 2), -random.uniform(1, 20)]
    numbers = lambda rows: "  ".join(" ".join(f"{v:.9g}" for v in row) for row in rows)
    shifted = [tuple(i + len(low) for i in c) for c in others]
    return f"""  <Node name="{name}">
    <EulerImplicitSolver newtonIterations="60" newtonTolerance="1e-6"/>
    <SparseLDLSolver/>
    <MeshTopology position="{numbers(low + high)}" tetrahedra="{numbers(cells + shifted)}"/>
    <MechanicalObject velocity="{numbers([(0, 0, 0)] * len(low) + [velocity] * len(high))}"/>
    <MeshMatrixMass massDensity="1000" lumping="true"/>
    <TetrahedronFEMForceField youngModulus="{10 ** random.uniform(4, 8):.6g}" poissonRatio="{random.choice([0, 0.3, 0.45])}"/>
    <BarrierContact contactDistance="0.02" friction="{random.choice([0, 0, 0.3])}"/>
  </Node>
"""


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--stroma", default=os.path.join(ROOT, "build", "release", "bin", "stroma"))
    arguments.add_argument("--pairs", type=int, default=10000)
    arguments.add_argument("--each", type=int, default=50, help="pairs of a scene")
    arguments.add_argument("--seed", type=int, default=1)
    asked = arguments.parse_args()
    random.seed(asked.seed)
    clean = steps = 0
    start = time.time()
    with tempfile.TemporaryDirectory() as folder:
        while clean < asked.pairs:
            count, dt = min(asked.each, asked.pairs - clean), random.choice([0.001, 0.005, 0.01, 0.025])
            # far enough for the slowest to meet, and few steps once the fastest have
            n = {0.001: 40, 0.005: 12, 0.01: 8, 0.025: 6}[dt]
            path = os.path.join(folder, "drops.xml")
            with open(path, "w") as file:
                file.write(f'<Node name="root" dt="{dt}" gravity="0 0 -9.81">\n')
                file.writelines(pair(f"pair_{i}") for i in range(count))
                file.write("</Node>\n")
            result = subprocess.run([asked.stroma, "run", path, "-n", str(n), "--quiet"], capture_output=True, text=True)
            if result.returncode != 0:
                kept = f"contact_drops_{asked.seed}_{clean}.xml"
                os.replace(path, kept)
                print(f"not clean, of the pairs {clean} to {clean + count - 1}, {n} steps of {dt} s: {kept}\n{result.stderr.strip()}")
                return 1
            clean, steps = clean + count, steps + n * count
            print(f"\r{clean} pairs clean in {steps} steps, {time.time() - start:.0f} s", end="", flush=True)
    print()
    return 0


if __name__ == "__main__":
    sys.exit(main())
