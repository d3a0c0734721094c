#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Statics of nearly incompressible bodies: nothing named, conjugate gradients with multigrid, and factors.

  docs/validate/incompressible.py --stroma build/release/bin/stroma
  docs/validate/incompressible.py --stroma ... --bodies "cube, hexahedra" --cells 20 --rounds 1

Cubes with mean dilatation hang from a face under their weight and a tenth of it across. Processor seconds of whole commands on one
thread, of the user and of the system, least of --rounds, in turns. Iterations are those of all linear solves. The last column is the
distance of the displacements from those of factors, relative to these. Prints the table of docs/scale.md. Needs numpy."""
import argparse
import json
import os
import resource
import subprocess
import tempfile

import numpy as np
import stroma_run as sr

SOLVERS = {
    "nothing named": "",
    "multigrid": '<PCGLinearSolver preconditioner="multigrid" tolerance="1e-8" iterations="2000"/>',
    "factors": "<SparseLDLSolver/>",
}
HEXAHEDRA = '<HexahedronFEMForceField method="{method}" dilatation="mean" youngModulus="100" poissonRatio="{poisson}"/>'
TETRAHEDRA = ('<TetrahedronSetTopologyContainer name="cells"/><Hexa2TetraTopologicalMapping input="@grid" output="@cells"/>'
              '<TetrahedronFEMForceField topology="@cells" method="{method}" dilatation="mean" youngModulus="100" poissonRatio="{poisson}"/>')
RUBBER = '<HexahedronHyperelasticityFEMForceField materialName="{method}" youngModulus="100" poissonRatio="{poisson}"/>'
# name: (field, method or law, acceleration)
BODIES = {
    "cube, hexahedra": (HEXAHEDRA, "small", 1),
    "cube, tetrahedra": (TETRAHEDRA, "small", 1),
    "cube, hexahedra, rotations": (HEXAHEDRA, "svd", 3),
    "cube, hyperelastic hexahedra": (RUBBER, "StableNeoHookean", 3),
}


def scene(body, cells, poisson, solver):
    field, method, weight = BODIES[body]
    return f"""<Node name="root" dt="1" gravity="{-0.1 * weight} 0 {-weight}">
  <StaticSolver name="solver"/>{SOLVERS[solver]}
  <RegularGridTopology name="grid" n="{cells + 1} {cells + 1} {cells + 1}" min="0 0 0" max="1 1 1"/>
  <MechanicalObject name="dofs"/>
  <MeshMatrixMass massDensity="1" topology="@grid"/>
  {field.format(method=method, poisson=poisson)}
  <BoxROI name="wall" box="-1 -1 -1 2 2 1e-6"/><FixedProjectiveConstraint indices="@wall.indices"/>
</Node>
"""


def run(stroma, text, record):
    """Processor seconds, the summary, and the last places of the nodes if they are recorded."""
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "block.xml")
        with open(file, "w") as out:
            out.write(text)
        line = [stroma, "run", file, "-n", "1", "--threads", "1", "--quiet", "--json"]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        result = subprocess.run(line + (["--record", folder] if record else ["--no-record"]), capture_output=True, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if result.returncode:
            raise SystemExit(result.stderr)
        states = [name for name in os.listdir(folder) if name.endswith(".state.gz")]
        places = sr.read_state(os.path.join(folder, states[0])) if record else None
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return seconds, json.loads(result.stdout), places


def displacement(stroma, text):
    _, _, places = run(stroma, text, True)
    return places[-1] - places[0]


def row(stroma, body, cells, poisson, solvers, rounds):
    texts = {name: scene(body, cells, poisson, name) for name in solvers}
    runs = [{name: run(stroma, text, False) for name, text in texts.items()} for _ in range(rounds)]
    cell = {}
    for name in solvers:
        cell[name] = f"{runs[0][name][1]['linear']['iterations']}, {min(each[name][0] for each in runs):.2f}"
    reference = displacement(stroma, scene(body, cells, poisson, "factors"))
    found = displacement(stroma, scene(body, cells, poisson, "nothing named"))
    apart = np.linalg.norm(found - reference) / np.linalg.norm(reference)
    return [f"{body}, {cells}^3, {poisson}"] + [cell.get(name, "") for name in SOLVERS] + [f"{apart:.1g}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stroma", required=True, help="the stroma command")
    parser.add_argument("--bodies", nargs="+", default=["cube, hexahedra"], choices=list(BODIES))
    parser.add_argument("--cells", nargs="+", type=int, default=[20, 30], help="cells along an edge")
    parser.add_argument("--poisson", nargs="+", default=["0.499", "0.4999"])
    parser.add_argument("--solvers", nargs="+", default=list(SOLVERS), choices=list(SOLVERS))
    parser.add_argument("--rounds", type=int, default=3, help="runs of each, of which the least counts (3)")
    arguments = parser.parse_args()
    stroma = os.path.abspath(arguments.stroma)
    print(sr.machine())
    print(sr.markdown(["", *SOLVERS, "apart"], []), end="")
    for body in arguments.bodies:
        for cells in arguments.cells:
            for poisson in arguments.poisson:
                found = row(stroma, body, cells, poisson, arguments.solvers, arguments.rounds)
                print("| " + " | ".join(found) + " |", flush=True)


if __name__ == "__main__":
    main()
