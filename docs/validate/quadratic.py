#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Error against processor time: the fixed beam of docs/validation.md by tetrahedra, hexahedra with and without incompatible modes, and
quadratic tetrahedra.

  docs/validate/quadratic.py --stroma build/release/bin/stroma

Each case is a whole command on one thread (read, mesh, solve, write), with the solver that is fastest for it of the two
tried (CGLinearSolver to 1e-8, SparseLDLSolver); the processor time is the least of --repeats runs, all cases in turn. The
error is that of the tip against Timoshenko's beam. Prints a table, and for each kind of cell the time to 0.5 %, between
the two meshes around it by the power law through them.
"""
import argparse
import math
import os
import resource
import subprocess
import sys
import tempfile

import stroma_run as sr

TIP = -48.096e-3  # m, Timoshenko, shear included
GOAL = 0.005
KINDS = {
    "five tetrahedra a cube": ("cantilever_distributed", [8, 12, 16, 20, 24], ""),
    "hexahedra": ("cantilever_distributed_hexahedra", [4, 8, 12, 16], ""),
    "hexahedra with incompatible modes": ("cantilever_distributed_hexahedra", [1, 2, 3, 4], 'incompatibleModes="true" '),
    "quadratic tetrahedra, five a cube": ("cantilever_distributed_quadratic", [1, 2, 3, 4], ""),
}
SOLVERS = {"CG": "CGLinearSolver", "LDL": "SparseLDLSolver"}


def scene_of(name, solver, cell_attributes, folder):
    """The validation scene with another linear solver."""
    with open(os.path.join(sr.ROOT, "scenes", "validation", name + ".xml"), encoding="utf-8") as file:
        text = file.read()
    attributes = ' iterations="20000" tolerance="1e-8" threshold="0"' if solver == "CG" else ""
    text = text.replace('<SparseLDLSolver name="linear"/>', f'<{SOLVERS[solver]} name="linear"{attributes}/>')
    text = text.replace("<HexahedronFEMForceField ", "<HexahedronFEMForceField " + cell_attributes)
    path = os.path.join(folder, f"{name}_{solver}.xml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path


def run(stroma, scene, cells):
    """(processor seconds, tip [m]) of one command."""
    with tempfile.TemporaryDirectory() as folder:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        result = subprocess.run([stroma, "run", scene, "--quiet", "--threads", "1", "-n", "1", "--record", folder, "--set",
                                 f"/grid.n={20 * cells + 1} {cells + 1} {cells + 1}"], capture_output=True, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if result.returncode != 0:
            sys.exit(result.stderr)
        states = [name for name in os.listdir(folder) if name.endswith(".state.gz")]
        frames = sr.read_state(os.path.join(folder, next(name for name in states if "beam" in name)))
    end = frames[0][:, 0] > 39.999
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return seconds, (frames[-1] - frames[0])[end, 2].mean()


def time_to_goal(rows):
    """Of (error, seconds) by falling error: the seconds at the goal, or None."""
    if rows[0][0] <= GOAL:
        return rows[0][1]
    for (coarse, cheap), (fine, dear) in zip(rows, rows[1:]):
        if fine <= GOAL:
            share = math.log(coarse / GOAL) / math.log(coarse / fine)
            return cheap * (dear / cheap) ** share
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stroma", required=True, help="the stroma command")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--only", default="", help="kinds of cells with this in their names")
    arguments = parser.parse_args()
    chosen = {kind: case for kind, case in KINDS.items() if arguments.only in kind}
    stroma = os.path.abspath(arguments.stroma)
    best = {}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(arguments.repeats):
            for kind, (name, meshes, cell_attributes) in chosen.items():
                for cells in meshes:
                    for solver in SOLVERS:
                        seconds, tip = run(stroma, scene_of(name, solver, cell_attributes, folder), cells)
                        key = (kind, cells, solver)
                        best[key] = (min(seconds, best.get(key, (seconds,))[0]), abs(tip / TIP - 1))
    rows, goals = [], []
    for kind, (_, meshes, _) in chosen.items():
        fastest = []
        for cells in meshes:
            (seconds, error), solver = min((best[kind, cells, solver], solver) for solver in SOLVERS)
            fastest.append((error, seconds))
            rows.append((kind, cells, f"{100 * error:.3f} %", f"{seconds:.2f} s", solver))
        goals.append((kind, time_to_goal(fastest)))
    print(sr.machine())
    print(sr.markdown(["cells", "over the height", "error of the tip", "processor time", "solver"], rows))
    print(sr.markdown(["cells", "time to 0.5 %"], [(kind, f"{t:.2f} s" if t else "not reached") for kind, t in goals]))


if __name__ == "__main__":
    main()
