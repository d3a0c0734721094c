#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Two builds of Stroma on the same scenes, in turns: the table "before and now" of docs/scale.md.

    tools/bench/two_builds.py --old OLD/build/release/bin/stroma --new build/release/bin/stroma
    tools/bench/two_builds.py --old ... --new ... --only statics --rounds 3

Rows of scenes are whole commands (load, mesh, steps): processor seconds (user and system), and iterations of linear solvers; --wall adds
wall seconds, for a quiet machine. The row of hexahedra is of one step. Other rows are lines of `stroma-bench`, beside the program. Each is
the least of --rounds, both builds in turns within a round. Both get the same scene, as a person writes it. Only hexahedra name a solver:
`CGLinearSolver` in the former build, which has no `AutomaticLinearSolver`."""
import argparse
import json
import os
import subprocess
import sys
import tempfile
import time

SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes", "benchmarks")
SMALL = ("/block/cells/fem.method=small",)
LDL = '<StaticSolver name="solver"/><SparseLDLSolver/>'
BEAM = ("/block/grid.n=321 17 17", "/block/grid.max=2.8 0.14 0.14", "/block/cells/fem.youngModulus=1e7")
FIVE = '<CGLinearSolver name="linear" iterations="5" tolerance="1e-30" threshold="1e-15"/>'


def block(cells):
    return (f"/block/grid.n={cells + 1} {cells + 1} {cells + 1}",)


class Scene:
    """A scene of scenes/benchmarks; `put` replaces a piece of its text, `old` the same for the former build. `steps` counts steps after the
    first `skipped` ones."""
    def __init__(self, key, about, goal, file, settings=(), put=None, old=None, steps=1, skipped=0, old_steps=0, rounds=99):
        self.key, self.about, self.goal, self.file, self.settings = key, about, goal, file, settings
        self.put, self.old, self.rounds = put, old or put, rounds
        self.steps, self.skipped, self.old_steps = steps, skipped, old_steps or steps

    def run(self, program, is_old, threads, folder):
        text = open(os.path.join(SCENES, self.file)).read()
        if put := self.old if is_old else self.put:
            assert put[0] in text, put[0]
            text = text.replace(*put)
        scene = os.path.join(folder, self.file)
        with open(scene, "w") as out:
            out.write(text)
        steps = self.old_steps if is_old else self.steps
        whole = self.command(program, scene, steps + self.skipped, threads)
        if not self.skipped or not whole:
            return whole
        before = self.command(program, scene, self.skipped, threads)
        return tuple((a - b) / steps for a, b in zip(whole, before))

    def command(self, program, scene, steps, threads):
        written = os.path.join(os.path.dirname(scene), "summary.json")
        command = [program, "run", scene, "-n", str(steps), "--quiet", "--no-record", "--threads", str(threads), f"--json={written}"]
        for setting in self.settings:
            command += ["--set", setting]
        began = time.monotonic()
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        said = process.stderr.read()
        _, status, used = os.wait4(process.pid, 0)
        wall = time.monotonic() - began
        process.returncode = status
        if status:
            print(f"    {self.about}: {said.strip().splitlines()[-1:]}", file=sys.stderr)
            return None
        iterations = json.load(open(written)).get("linear", {}).get("iterations", 0)
        return used.ru_utime + used.ru_stime, wall, iterations

    @staticmethod
    def text(best, with_wall):
        seconds, wall, iterations = best
        return f"{seconds:.3g} s{f' ({wall:.3g} s)' if with_wall else ''}, {iterations:.0f}"


class Figure:
    """A line of stroma-bench."""
    rounds = 99

    def __init__(self, key, about, goal, name):
        self.key, self.about, self.goal, self.name = key, about, goal, name

    def run(self, program, _is_old, _threads, folder):
        written = os.path.join(folder, "figures.json")
        command = [program + "-bench", f"--benchmark_filter=^{self.name}$", "--json", written]
        done = subprocess.run(command, capture_output=True, text=True)
        figures = json.load(open(written))["figures"] if done.returncode == 0 else []
        if not figures:
            print(f"    {self.name}: no such figure", file=sys.stderr)
            return None
        self.unit = figures[0]["unit"].split("/")[0]
        return figures[0]["least"], figures[0]["median"], 0

    def text(self, best, _with_wall):
        return f"{best[0]:.3g} {self.unit}"


ROWS = (
    Scene("statics", "statics, 344,605 tetrahedra, linear", "1.8 s", "statics.xml", SMALL + block(41)),
    Scene("statics_large", "the same, 1,572,160", "7 s", "statics.xml", SMALL + block(68), rounds=1),
    Scene("svd", "statics, 344,605 tetrahedra, `svd`", "4 s", "statics.xml", block(41), rounds=2),
    Scene("svd_large", "the same, 1,572,160", "18 s", "statics.xml", block(68), rounds=1),
    Scene("svd_small", "statics, 135,000 tetrahedra, `svd`", "", "statics.xml", rounds=1),
    Scene("svd_direct", "135,000, `svd`, `SparseLDLSolver` named", "", "statics.xml", (), ('<StaticSolver name="solver"/>', LDL), rounds=1),
    Scene("beam", "beam 20:1 of 409,600, linear", "twice the cube's", "statics.xml", SMALL + BEAM, rounds=1),
    Scene("hexahedra", "a step of 262,144 hexahedra to 1e-3", "0.33 s", "hexahedra.xml", ("/cube/grid.n=65 65 65",),
          (FIVE, '<AutomaticLinearSolver tolerance="1e-3"/>'), (FIVE, '<CGLinearSolver iterations="2000" tolerance="1e-3"/>'),
          steps=8, skipped=12, old_steps=3, rounds=1),
    Scene("compressed", "compressed cube, 24 x 24 x 24 hexahedra", "", "compressed_cube.xml", ("/cube/grid.n=25 25 25",), rounds=2),
    Figure("step", "step, 5,000 tetrahedra, `large`, 5 iterations", "0.12 ms", "step cube 5,000 large"),
    Figure("product", "product, 10,000 tetrahedra", "2.5 ns", "product 10k"),
    Figure("venant", "St. Venant-Kirchhoff step, 20,480 tetrahedra", "0.9 ms", "hyperelastic step StVenantKirchhoff"),
    Figure("direct", "direct step, 1,331 nodes", "4 ms", "step cube 5,000 large, direct"),
)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--old", required=True, metavar="PROGRAM")
    parser.add_argument("--new", required=True, metavar="PROGRAM")
    parser.add_argument("--only", default="", metavar="ROW,ROW", help=", ".join(row.key for row in ROWS))
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--wall", action="store_true")
    asked = parser.parse_args()
    names = [name for name in asked.only.split(",") if name]
    if unknown := set(names) - {row.key for row in ROWS}:
        parser.error("there is no row " + ", ".join(sorted(unknown)))
    print("| | before | now | times | goal | load |\n|---|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for row in ROWS:
            if names and row.key not in names:
                continue
            found = {True: [], False: []}
            for _ in range(min(asked.rounds, row.rounds)):
                for is_old in (True, False):
                    found[is_old].append(row.run(asked.old if is_old else asked.new, is_old, asked.threads, folder))
            best = {is_old: min(runs) if all(runs) else None for is_old, runs in found.items()}
            times = f"{best[True][0] / best[False][0]:.1f}" if all(best.values()) else ""
            before, now = (row.text(best[is_old], asked.wall) if best[is_old] else "-" for is_old in (True, False))
            print(f"| {row.about} | {before} | {now} | {times} | {row.goal} | {os.getloadavg()[0]:.0f} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
