#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Erleben's ten degenerate cases (2018) as PolyFEM has them (polyfem-data, contact/examples/3D/unit-tests/erleben): a neo-Hookean body
on a rigid obstacle, backward Euler with steps of 25 ms.

  contact_erleben.py
  contact_erleben.py --only spikes "inner edges" --levels 0 1 2
  contact_erleben.py --only spikes "spike on wedge" --balanced

PolyFEM publishes the largest displacement at the quadrature points of its linear cells, which are their centres. The table has that of
centres and that of nodes at the end, the first step after which something touches, in how many it does, the steps that did not converge,
and those with crossings. Needs the Python package of the build: PYTHONPATH=build/release/python.
"""
import argparse
import sys
import warnings

import numpy as np
import stroma

DT, GRAVITY, ABOVE = 0.025, 9.81, 1e-4
SPIKE = ([(-.5, 0, -.5), (.5, 0, -.5), (.5, 0, .5), (-.5, 0, .5), (0, 3, 0)], [(0, 1, 2, 4), (0, 2, 3, 4)])
WEDGE = ([(-.5, 0, -1), (.5, 0, -1), (0, 3, -1), (-.5, 0, 1), (.5, 0, 1), (0, 3, 1)], [(0, 1, 2, 3), (1, 2, 3, 4), (2, 3, 4, 5)])


def positive(points, cells):
    fixed = []
    for a, b, c, d in cells:
        u, v, w = (points[i] - points[a] for i in (b, c, d))
        fixed.append((a, b, c, d) if np.dot(np.cross(u, v), w) > 0 else (b, a, c, d))
    return fixed


def box(low, high, n):
    """A grid of boxes, each cut in six."""
    axes = [np.linspace(low[k], high[k], n[k] + 1) for k in range(3)]
    points = [np.array((x, y, z)) for z in axes[2] for y in axes[1] for x in axes[0]]

    def node(i, j, k):
        return i + (n[0] + 1) * (j + (n[1] + 1) * k)

    cells = [tuple(node(i + (b & 1), j + (b >> 1 & 1), k + (b >> 2)) for b in (0, p, p | q, 7))
             for k in range(n[2]) for j in range(n[1]) for i in range(n[0])
             for p, q in ((1, 2), (1, 4), (2, 1), (2, 4), (4, 1), (4, 2))]
    return points, cells


def refined(points, cells):
    """Each tetrahedron in eight."""
    points, middles, fine = list(points), {}, []

    def middle(a, b):
        key = (min(a, b), max(a, b))
        if key not in middles:
            middles[key] = len(points)
            points.append((points[a] + points[b]) / 2)
        return middles[key]
    for a, b, c, d in cells:
        ab, ac, ad, bc, bd, cd = middle(a, b), middle(a, c), middle(a, d), middle(b, c), middle(b, d), middle(c, d)
        fine += [(a, ab, ac, ad), (ab, b, bc, bd), (ac, bc, c, cd), (ad, bd, cd, d),
                 (ab, ac, ad, bd), (ab, ac, bc, bd), (ac, ad, cd, bd), (ac, bc, cd, bd)]
    return points, fine


def pit(deep, length, n):
    """A plate whose middle nodes of the top are pulled down: a pyramid or a groove."""
    points, cells = box((-1, -.5, -length), (1, .5, length), n)
    for p in points:
        if deep(p) and p[1] > 0:
            p[1] = 0
    return points, cells


def body(shape, turned=False, rise=0.0, along=0.0):
    points = [np.array(p, float) for p in shape[0]]
    for p in points:
        p *= (-1, -1, 1) if turned else (1, 1, 1)  # half a turn about z
        p += (along, rise, 0)
    return points, shape[1]


def cases():
    """By name: what moves, the obstacle, velocity of the held top, steps, (Young, Poisson, density), PolyFEM's number."""
    cube, cliff = box((-.5, -.5, -.5), (.5, .5, .5), (1, 1, 1)), box((-.5, -.5, -.5), (.5, .5, .5), (1, 1, 1))
    for p in cliff[0]:
        if p[1] < 0:
            p *= (1.5, 1, 1.5)
    hole = pit(lambda p: p[0] == 0 and p[2] == 0, 1, (4, 1, 4))
    crack, flat = pit(lambda p: p[0] == 0, 2, (4, 1, 1)), box((-1, -.5, -1), (1, .5, 1), (4, 1, 4))
    wide = box((-20, -.5, -20), (20, .0, 20), (1, 1, 1))
    soft, steel = (1e6, 0.4, 1000), (2e11, 0.3, 7750)
    return {
        "spikes": (body(SPIKE, True, 3 + ABOVE), body(SPIKE, False, -3), None, 50, soft, 0.0521064),
        "spike on wedge": (body(SPIKE, True, 3 + ABOVE), body(WEDGE, False, -3), None, 50, soft, 0.0521367),
        "wedges": (body(WEDGE, True, 3 + ABOVE), body(WEDGE, False, -3), None, 50, soft, 7.52054),
        "spike in a hole": (body(SPIKE, True, 3 + ABOVE), hole, 1, 200, soft, 4.87538),
        "spike in a crack": (body(SPIKE, True, 3 + ABOVE), crack, 1, 200, soft, 4.95815),
        "wedge in a crack": (body(WEDGE, True, 3 + ABOVE), crack, 1, 240, soft, 5.89565),
        "sliding spike": (body(SPIKE, True, 3 + ABOVE, -4.9), wide, 10, 40, steel, 10.0),
        "sliding wedge": (body(WEDGE, True, 3 + ABOVE, 4.9), wide, -10, 40, steel, 10.0),
        "cliff edges": (body(cube, False, 1.05), cliff, None, 100, soft, None),
        "inner edges": (body(cube, False, 1.05), flat, None, 200, soft, 0.0584107)}


def numbers(rows):
    return "  ".join(" ".join(f"{value:.15g}" for value in row) for row in rows)


def indices(rows):
    return "  ".join(" ".join(map(str, row)) for row in rows)


def surface(points, cells):
    """Triangles of the boundary, outward."""
    faces = {}
    for a, b, c, d in positive(points, cells):
        for face in ((a, c, b), (a, b, d), (b, c, d), (a, d, c)):
            key = tuple(sorted(face))
            faces[key] = None if key in faces else face
    return [face for face in faces.values() if face]


def scene(points, cells, obstacle, velocity, steps, material, dt, balanced=False):
    young, poisson, density = material
    top = max(p[1] for p in points)
    held = joined(i for i, p in enumerate(points) if p[1] > top - 1e-9)
    end = 2 * steps * dt
    hand = "" if velocity is None else (f'<LinearMovementProjectiveConstraint indices="{held}" keyTimes="0 {end}" '
                                        f'movements="0 0 0  {velocity * end} 0 0"/>')
    if balanced:
        tip = joined(i for i, p in enumerate(points) if p[1] < min(q[1] for q in points) + 1e-9)
        hand += f'<PartialFixedProjectiveConstraint indices="{tip}" fixedDirections="1 0 1"/>'
    return (f'<Node name="root" dt="{dt}" gravity="0 {-GRAVITY} 0"><EulerImplicitSolver newtonIterations="100" newtonTolerance="1e-8"/>'
            f'<SparseLDLSolver/><MeshTopology name="ground" position="{numbers(obstacle[0])}" triangles="{indices(surface(*obstacle))}"/>'
            f'<Node name="body"><MeshTopology name="mesh" position="{numbers(points)}" tetrahedra="{indices(positive(points, cells))}"/>'
            f'<MechanicalObject name="dofs"/><MeshMatrixMass massDensity="{density}" lumping="true"/>'
            f'<TetrahedronHyperelasticityFEMForceField materialName="NeoHookean" youngModulus="{young}" poissonRatio="{poisson}"/>{hand}'
            f'<BarrierContact name="contact" contactDistance="1e-3" selfContact="0" meshes="@../ground"/></Node></Node>')


def joined(items):
    return " ".join(map(str, items))


def run(name, level, dt, balanced=False):
    (points, cells), obstacle, velocity, steps, material, published = cases()[name]
    steps = round(steps * DT / dt)
    for _ in range(level):
        points, cells = refined(points, cells)
    start, cells = np.array(points), np.array(cells)
    simulation = stroma.load(stroma.from_xml_text(scene(points, cells, obstacle, velocity, steps, material, dt, balanced)), quiet=True)
    contact, first, unconverged, touching = simulation["/body/contact"], 0, 0, 0
    for step in range(1, steps + 1):
        report = simulation.step()
        unconverged += not report.newton_converged
        if contact.smallestGap > 0:
            first, touching = first or step, touching + 1
    moved = np.array(simulation.state("/body").x) - start
    centres = np.linalg.norm(moved[cells].mean(axis=1), axis=1).max()
    nodes = np.linalg.norm(moved, axis=1).max()
    return [name, str(len(cells)), f"{first} of {steps}", str(touching), f"{centres:.5f}", f"{nodes:.5f}",
            "" if published is None else f"{published:.5f}", str(unconverged), str(contact.crossings)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=list(cases()), default=list(cases()))
    parser.add_argument("--levels", nargs="+", type=int, default=[0, 1], help="how often each tetrahedron is cut in eight")
    parser.add_argument("--dt", type=float, default=DT)
    parser.add_argument("--balanced", action="store_true", help="what touches first is held across the vertical")
    asked = parser.parse_args()
    print("| case | cells | first touch | steps in touch | centres | nodes | PolyFEM | unconverged | crossings |\n" + 9 * "|---" + "|")
    for name in asked.only:
        for level in asked.levels:
            print("| " + " | ".join(run(name, level, asked.dt, asked.balanced)) + " |", flush=True)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    sys.exit(main())
