#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Forty static problems in one step each: Newton's iterations, the parts that a step was divided into, and times.

  docs/validate/statics.py --stroma build/release/bin/stroma --out docs/experiments
  docs/validate/statics.py --stroma ... --out ... --before OTHER/bin/stroma   # the same of another build beside it

Blocks of 4 x 4 x 4 cells pressed to 0.4 or drawn to 2.5 times their height, beams of 16 x 2 x 2 cells that sag
under their weight, laws and corotational methods with both tangents, Poisson's ratio up to 0.49999. Each case runs nine
times; times are medians of whole steps, the two builds in turn. Writes OUT/statics.md.
"""
import argparse
import datetime
import json
import os
import statistics
import subprocess
import sys
import tempfile

import stroma_run as sr

TETRAHEDRA, HEXAHEDRA = "tetrahedra", "hexahedra"
LAWS = {"NeoHookean": "1000 4000", "MooneyRivlin": "300 200 5000", "StableNeoHookean": "1000 4000",
        "VerondaWestman": "500 2 5000", "ArrudaBoyce": "1000 5000", "Ogden": "1500 4 500 -2 5000", "Yeoh": "500 -30 20 5000",
        "Hencky": "1000 4000", "OgdenUnconstrained": "1500 3 500 -2 4000"}
REPEATS = 9

PRESSED = """<Node name="root" dt="1" gravity="0 0 0">
  <StaticSolver/><SparseLDLSolver/>
  <RegularGridTopology name="grid" n="5 5 5" min="0 0 0" max="1 1 1"/>
  <MechanicalObject name="dofs"/>
  <BoxROI name="floor" box="-1 -1 -0.01  2 2 0.01"/><BoxROI name="top" box="-1 -1 0.99  2 2 1.01"/>
  <FixedProjectiveConstraint indices="@floor.indices"/>
  <LinearMovementProjectiveConstraint indices="@top.indices" keyTimes="0 1" movements="0 0 0  0 0 {move}" outside="hold"/>
  <Node name="cells"><TetrahedronSetTopologyContainer name="tets"/>
    <Hexa2TetraTopologicalMapping input="@../grid" output="@tets"/>
    {field}</Node></Node>"""

SAGGING = """<Node name="root" dt="1" gravity="0 0 {gravity}">
  <StaticSolver/><SparseLDLSolver/>
  <RegularGridTopology name="grid" n="17 3 3" min="0 0 0" max="8 1 1"/>
  <MechanicalObject name="dofs"/><UniformMass totalMass="8"/>
  <BoxROI name="wall" box="-0.01 -1 -1  0.01 2 2"/><FixedProjectiveConstraint indices="@wall.indices"/>
  <Node name="cells"><TetrahedronSetTopologyContainer name="tets"/>
    <Hexa2TetraTopologicalMapping input="@../grid" output="@tets"/>
    {field}</Node></Node>"""


def topology(cells):
    return "@tets" if cells == TETRAHEDRA else "@../grid"


def law_field(cells, law, more=""):
    kind = "TetrahedronHyperelasticityFEMForceField" if cells == TETRAHEDRA else "HexahedronHyperelasticityFEMForceField"
    return f'<{kind} topology="{topology(cells)}" materialName="{law}" ParameterSet="{LAWS[law]}" {more}/>'


def elastic_field(cells, method, poisson, more=""):
    kind = "TetrahedronFEMForceField" if cells == TETRAHEDRA else "HexahedronFEMForceField"
    return (f'<{kind} topology="{topology(cells)}" method="{method}" youngModulus="10000" poissonRatio="{poisson}" {more}/>')


def cases():
    """Rows of (body, cells, law or method, load, scene)."""
    for law in LAWS:
        for cells in (TETRAHEDRA, HEXAHEDRA):
            yield "block", cells, law, "to 0.4", PRESSED.format(move=-0.6, field=law_field(cells, law))
    for law in ("NeoHookean", "Yeoh", "Ogden"):
        for cells in (TETRAHEDRA, HEXAHEDRA):
            yield "block", cells, law, "to 2.5", PRESSED.format(move=1.5, field=law_field(cells, law))
    for cells, gravity in ((TETRAHEDRA, -20), (HEXAHEDRA, -14)):
        for method, tangent in (("polar", "warped"), ("polar", "exact"), ("svd", "exact")):
            yield ("beam", cells, f"{method}, tangent {tangent}", "sags by 0.6 of its length",
                   SAGGING.format(gravity=gravity, field=elastic_field(cells, method, 0.3, f'tangent="{tangent}"')))
    for poisson in (0.45, 0.499, 0.49999):
        for cells in (TETRAHEDRA, HEXAHEDRA):
            more = 'dilatation="mean" tangent="exact"'
            yield ("beam", cells, f"svd, mean dilatation, Poisson's ratio {poisson}", "sags a little",
                   SAGGING.format(gravity=-0.3, field=elastic_field(cells, "svd", poisson, more)))
    for cells in (TETRAHEDRA, HEXAHEDRA):
        yield ("block", cells, "polar, tangent exact", "to 0.8",
               PRESSED.format(move=-0.2, field=elastic_field(cells, "polar", 0.3, 'tangent="exact"')))
    yield ("block", TETRAHEDRA, "MooneyRivlin", "to 0.3",
           PRESSED.format(move=-0.7, field=law_field(TETRAHEDRA, "MooneyRivlin")))
    yield ("block", HEXAHEDRA, "NeoHookean, mean dilatation", "to 0.7",
           PRESSED.format(move=-0.3, field=law_field(HEXAHEDRA, "NeoHookean", 'dilatation="mean"')))


def solve(program, scene):
    """(what is to be read, seconds or None); the time of the step alone."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scene.xml")
        with open(path, "w") as file:
            file.write(scene)
        result = subprocess.run([program, "run", path, "-n", "1", "--quiet", "--no-record", "--json", "-", "--threads", "1"],
                                cwd=folder, capture_output=True, text=True)
    if not result.stdout.lstrip().startswith("{"):
        return None, None
    summary = json.loads(result.stdout)
    return (summary if result.returncode == 0 else {"code": result.returncode}), summary["ms_per_step"]["median"]


def text(summary):
    if summary is None:
        return ["not known", ""]
    if "code" in summary:
        return [f"stops, exit code {summary['code']}", ""]
    newton = summary["solvers"]["newton"] if "solvers" in summary else summary["newton"]
    parts = newton.get("most_parts_of_a_step", 1)
    return [newton["iterations"], max(1, parts)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stroma", required=True, help="the stroma command")
    parser.add_argument("--before", help="the command of another build")
    parser.add_argument("--out", required=True, help="folder for the page")
    arguments = parser.parse_args()
    programs = [os.path.abspath(program) for program in (arguments.stroma, arguments.before) if program]
    rows, failures, slower = [], 0, []
    for number, (body, cells, law, load, scene) in enumerate(cases(), 1):
        runs = [[solve(program, scene) for program in programs] for _ in range(REPEATS)]
        summary = runs[0][0][0]
        failures += summary is None or "code" in summary
        taken = [[run[i][1] for run in runs if run[i][1] is not None] for i in range(len(programs))]
        times = [statistics.median(of_program) if of_program else None for of_program in taken]
        row = [number, body, cells, law, load, *text(summary), f"{times[0]:.1f}" if times[0] else ""]
        if len(programs) > 1:
            row += [*text(runs[0][1][0]), f"{times[1]:.1f}" if times[1] else ""]
            worked = runs[0][1][0] is not None and "code" not in runs[0][1][0]
            if worked and times[0] > 1.05 * times[1]:
                slower.append(number)
        rows.append(row)
        print(*row, sep=" | ", flush=True)
    header = ["", "body", "cells", "law or method", "load in one step", "iterations", "parts", "ms"]
    if len(programs) > 1:
        header += ["before: iterations", "parts", "ms"]
    with open(os.path.join(arguments.out, "statics.md"), "w") as file:
        file.write(f"Written by `docs/validate/statics.py` on {datetime.date.today()}; {sr.machine()}.\n\n"
                   "# Static steps\n\n"
                   "Newton's iterations of a step, those of parts that failed included, and into how many parts it was "
                   "divided. Times are medians of nine runs, one thread.\n\n" + sr.markdown(header, rows))
    print(f"{len(rows)} cases, {failures} without an equilibrium, slower by more than 5 %: {slower or 'none'}")
    sys.exit(failures > 0)


if __name__ == "__main__":
    main()
