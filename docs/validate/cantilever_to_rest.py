#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""A bent cantilever to 1 % of the deflection of its end: the paper's configuration in time, and statics.

  PYTHONPATH=build/release/python /usr/bin/python3 docs/validate/cantilever_to_rest.py

scenes/benchmarks/cantilever.xml. The paper (Nesme, Payan, Faure 2005): implicit Euler steps of 0.4 ms with five iterations of conjugate gradients,
`polar` with an updated B, no damping, a load that grows gradually (here over 0.5 s), until the body rests. It rests when the end stays
within 1 % of the static solution of the same mesh and method; that run has to go on for --after seconds to show it. Statics: the same mesh
with nothing named but the law, and quadratic tetrahedra.
Processor seconds of loading and steps on one thread, least of --rounds; the error is that against 1,620 hexahedra of 20 nodes in CalculiX, known
to 0.75 %."""
import argparse
import os
import time

import numpy
import stroma

SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes", "benchmarks")
REFERENCE = -0.0604762  # m, tools/bench/accuracy_references.py
DT, ITERATIONS, GROWTH, PIECE = 0.4e-3, 5, 0.5, 25  # s, , s, steps
QUADRATIC = "11 2 2", "21 2 2", "31 2 2", "21 3 3"
FORCE = -0.3333333333  # N
STEPS = f'<EulerImplicitSolver name="solver"/><CGLinearSolver name="linear" iterations="{ITERATIONS}" tolerance="1e-30" threshold="1e-30"/>'


def end_of(simulation):
    """How far the end has gone down."""
    state = simulation.states()[0]
    end = state.rest[:, 0] > 0.1999
    return (state.x - state.rest)[end, 1].mean()


def scene_of(cells, paper):
    """cantilever.xml with its solvers replaced."""
    text = open(os.path.join(SCENES, "cantilever.xml"), encoding="utf-8").read()
    begin, end = text.index("<StaticSolver"), text.index("<RegularGridTopology")
    text = text[:begin] + (STEPS if paper else '<StaticSolver name="solver"/>') + text[end:]
    tree = stroma.from_xml_text(text)
    return tree, {"/beam/grid.n": f"{10 * cells + 1} {cells + 1} {cells + 1}", "/beam/cells/fem.method": "polar",
                  "/beam/cells/fem.tangent": "warped", "/beam/cells/fem.updateStiffnessMatrix": True, **({"dt": DT} if paper else {})}


def statics(load):
    begin = time.process_time()
    simulation = load()
    simulation.step()
    return time.process_time() - begin, end_of(simulation)


def to_rest(cells, target, after):
    """Processor seconds until the end stays within 1 % of `target`, the time of the simulation, and its last place."""
    begin = time.process_time()
    tree, settings = scene_of(cells, True)
    simulation = stroma.load(tree, set={**settings, "/beam/pull.totalForce": "0 0 0"}, observers=False, quiet=True)
    pull = simulation["/beam/pull"]
    rested, took, pieces = None, 0, 0
    while rested is None or simulation.time - rested < after:
        if simulation.time < GROWTH:
            pull.totalForce = [0, FORCE * min(1, simulation.time / GROWTH + PIECE * DT / GROWTH), 0]
        simulation.run(steps=PIECE)
        pieces += 1
        if abs(end_of(simulation) / target - 1) > 0.01:
            rested = None
        elif rested is None:
            rested, took = simulation.time, time.process_time() - begin
    return took, rested, end_of(simulation)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cells", type=int, default=2, help="over the height, of five tetrahedra each")
    parser.add_argument("--after", type=float, default=2, help="how long the end has to stay [s]")
    parser.add_argument("--rounds", type=int, default=3, help="of statics")
    asked = parser.parse_args()
    stroma.set_threads(1)
    tree, settings = scene_of(asked.cells, False)
    same = [statics(lambda: stroma.load(tree, set=settings, observers=False, quiet=True)) for _ in range(asked.rounds)]
    quadratic = os.path.join(SCENES, "cantilever_quadratic.xml")
    best = {n: [statics(lambda n=n: stroma.load(quadratic, set={"/beam/grid.n": n}, observers=False, quiet=True)) for _ in range(asked.rounds)]
            for n in QUADRATIC}
    took, rested, end = to_rest(asked.cells, same[0][1], asked.after)
    rows = [("the paper's, in time", took, end), ("statics, the same mesh and law", min(s for s, _ in same), same[0][1]),
            *((f"statics, quadratic tetrahedra on a grid of {n}", min(s for s, _ in found), found[0][1]) for n, found in best.items())]
    print(f"at rest after {rested:.1f} s of the simulation, {rested / DT:.0f} steps")
    print("| | seconds | times less | end [mm] | error |\n|---|---|---|---|---|")
    for name, seconds, place in rows:
        print(f"| {name} | {seconds:.3f} | {took / seconds:.0f} | {1000 * place:.2f} | {100 * (place / REFERENCE - 1):+.1f} % |")


if __name__ == "__main__":
    main()
