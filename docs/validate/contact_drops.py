#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Pairs of bodies that fly into each other, at random: shapes, attitudes, velocities, moduli, steps of 1 to 25 ms. A share of the pairs
are organs and other real meshes, slower and less soft: those of scenes/meshes, and of ../shared/data/meshes if that is there. After every
step the contact's exact test of all edges against all triangles must have found nothing, and every number must be finite. Usage:

  contact_drops.py [--pairs 10000] [--real 0.01] [--seed 1]

Prints how many were clean, how many met and how many steps did not converge. The first pair that is not clean is kept and named, and the
exit code is 1. Needs the Python package of the build: PYTHONPATH=build/release/python.
"""
import argparse
import math
import os
import random
import sys
import time
import warnings

import numpy as np
import stroma

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
SHARED = os.environ.get("STROMA_SHARED_DATA") or os.path.join(ROOT, "..", "shared", "data")
REAL = [os.path.join(ROOT, "scenes", "meshes", name) for name in ("organ_300.vtk", "organ_600.msh")] + [
    os.path.join(SHARED, "meshes", name)
    for name in ("liver.msh", "liver2.msh", "torus2_low_res.msh", "cylinder.msh", "truthcylinder1.msh")]
CUBE = ([(i & 1, i >> 1 & 1, i >> 2) for i in range(8)],
        [(0, a, a | b, 7) for a, b in ((1, 2), (1, 4), (2, 1), (2, 4), (4, 1), (4, 2))])
SPIKE = ([(-.5, 0, -.5), (.5, 0, -.5), (.5, 0, .5), (-.5, 0, .5), (0, 3, 0)], [(0, 1, 2, 4), (0, 2, 3, 4)])
WEDGE = ([(-.5, 0, -1), (.5, 0, -1), (0, 3, -1), (-.5, 0, 1), (.5, 0, 1), (0, 3, 1)], [(0, 1, 2, 3), (1, 2, 3, 4), (2, 3, 4, 5)])


def volume(points, cell):
    a, b, c, d = (points[i] for i in cell)
    return np.dot(np.cross(b - a, c - a), d - a) / 6


def rotated(points):
    """By a random rotation, from a random quaternion."""
    w, x, y, z = np.array([random.gauss(0, 1) for _ in range(4)])
    size = math.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w / size, x / size, y / size, z / size
    return points @ np.array(((1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
                              (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
                              (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)))).T


def real_bodies():
    """(points, cells) of each file, 2 long and around the origin; cells of one piece of a mesh, and its nodes alone."""
    bodies = []
    for path in REAL:
        if not os.path.exists(path):
            print("left out, as it is not there:", os.path.normpath(path))
            continue
        loader = "MeshGmshLoader" if path.endswith(".msh") else "MeshVTKLoader"
        simulation = stroma.load(stroma.from_xml_text(
            f'<Node name="root"><StaticSolver/><{loader} name="loader" filename="{os.path.abspath(path)}"/>'
            '<TetrahedronSetTopologyContainer name="mesh" src="@loader"/><MechanicalObject/><UniformMass totalMass="1"/></Node>'),
            quiet=True)
        cells = np.array(simulation["/mesh"].tetrahedra).reshape(-1, 4)
        used, cells = np.unique(cells, return_inverse=True)
        points, cells = np.array(simulation.states()[0].x)[used], cells.reshape(-1, 4)
        low, high = points.min(axis=0), points.max(axis=0)
        bodies.append((2 / (high - low).max() * (points - (low + high) / 2), cells))
    return bodies


def body(real):
    """Rotated at random, cells with positive volumes."""
    kind = random.choice(["tetrahedron", "box", "plate", "needle", "spike", "wedge"])
    if real:
        points, cells = random.choice(real)
    elif kind == "tetrahedron":
        while True:
            points, cells = np.array([[random.uniform(-1, 1) for _ in range(3)] for _ in range(4)]), [(0, 1, 2, 3)]
            if abs(volume(points, cells[0])) > 0.03:
                break
    elif kind in ("spike", "wedge"):
        points, cells = SPIKE if kind == "spike" else WEDGE
    else:
        points, cells = np.array(CUBE[0]) * {"box": (1, 1, 1), "plate": (1.5, 1.5, 0.1), "needle": (0.1, 0.1, 2)}[kind], CUBE[1]
    points = rotated(np.array(points, float))
    return points, [tuple(c) if volume(points, c) > 0 else (c[1], c[0], c[2], c[3]) for c in cells]


def numbers(rows):
    return "  ".join(" ".join(f"{v:.9g}" for v in row) for row in rows)


def pair(real, dt):
    """A scene: the second body starts 0.03 above the first, with its lowest point about over the highest one, and comes down."""
    (low, cells), (high, others) = body(real), body(real)
    aside = np.array((random.uniform(-.02, .02), random.uniform(-.02, .02), 0.03))
    high = high + low[low[:, 2].argmax()] - high[high[:, 2].argmin()] + aside
    velocity = [random.uniform(-2, 2), random.uniform(-2, 2), -random.uniform(1, 5 if real else 20)]
    young = 10 ** random.uniform(6 if real else 4, 8)
    shifted = [tuple(i + len(low) for i in c) for c in others]
    text = "  ".join(" ".join(map(str, c)) for c in cells + shifted)
    return f"""<Node name="root" dt="{dt}" gravity="0 0 -9.81">
  <EulerImplicitSolver newtonIterations="60" newtonTolerance="1e-6"/>
  <SparseLDLSolver/>
  <MeshTopology position="{numbers(np.vstack((low, high)))}" tetrahedra="{text}"/>
  <MechanicalObject velocity="{numbers([(0, 0, 0)] * len(low) + [velocity] * len(high))}"/>
  <MeshMatrixMass massDensity="1000" lumping="true"/>
  <TetrahedronFEMForceField youngModulus="{young:.6g}" poissonRatio="{random.choice([0, 0.3, 0.45])}" method="svd"/>
  <BarrierContact name="contact" contactDistance="0.02" friction="{random.choice([0, 0, 0.3])}"/>
</Node>
"""


class Counts:
    """Of pairs and of their steps."""

    def __init__(self):
        self.pairs = self.met = self.steps = self.unconverged = 0

    def add(self, simulation, steps):
        """What is wrong with the pair, or an empty text."""
        contact, met = simulation["/contact"], False
        for step in range(steps):
            report = simulation.step()
            self.steps += 1
            self.unconverged += not report.newton_converged
            met = met or contact.smallestGap > 0
            if contact.crossings or not np.isfinite(simulation.states()[0].x).all():
                return f"step {step + 1}: {contact.crossings} crossings"
        self.pairs, self.met = self.pairs + 1, self.met + met
        return ""

    def text(self):
        return f"{self.pairs} pairs clean, {self.met} met, {self.unconverged} of {self.steps} steps did not converge"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=10000)
    parser.add_argument("--real", type=float, default=0.01, help="share of pairs of real meshes")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    random.seed(asked.seed)
    warnings.simplefilter("ignore")
    meshes, simple, real, start = real_bodies() if asked.real > 0 else [], Counts(), Counts(), time.process_time()
    for number in range(asked.pairs):
        is_real, dt = random.random() < asked.real, random.choice([0.001, 0.005, 0.01, 0.025])
        # far enough for the slowest to meet, and few steps once the fastest have
        text, steps = pair(meshes if is_real else [], dt), {0.001: 40, 0.005: 12, 0.01: 8, 0.025: 6}[dt]
        try:
            wrong = (real if is_real else simple).add(stroma.load(stroma.from_xml_text(text), quiet=True), steps)
        except stroma.StepError as error:
            wrong = str(error)
        if wrong:
            kept = f"contact_drops_{asked.seed}_{number}.xml"
            with open(kept, "w", encoding="utf-8") as file:
                file.write(text)
            print(f"\nnot clean: pair {number}, {wrong}: {kept}")
            return 1
        if number % 50 == 49:
            print(f"\rsimple shapes: {simple.text()}; real meshes: {real.text()}; {time.process_time() - start:.0f} s", end="", flush=True)
    print()
    return 0


if __name__ == "__main__":
    sys.exit(main())
