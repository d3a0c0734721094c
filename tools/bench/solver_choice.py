#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""How near the solver that nobody named comes to the best that could be named.

    tools/bench/solver_choice.py                              all sets
    tools/bench/solver_choice.py --set fresh --rounds 5
    tools/bench/solver_choice.py --only arch,dice --stroma build/release/bin/stroma

Each scene of solver_scenes.py runs without a linear solver and with each of the grid, in turns: processor seconds of the whole
command on one thread, medians. What takes three times as long as nothing named is stopped. After the first round only those
go on that are within 1.5 of the best. Newton's method with a named solver by products counts with its usual forcing term and with
0.1, whichever is faster. Printed are the ratio to the best named, and how far the end positions of nothing named are from those of
the most exact of the grid, relative to the largest displacement. --limit ends with 1 when a ratio is above it."""
import argparse
import json
import os
import resource
import shlex
import statistics
import struct
import subprocess
import sys
import tempfile

import solver_scenes

PRODUCTS = '<PCGLinearSolver name="linear" preconditioner="{}" template="{}"/>'
GRID = {"SparseLDLSolver": '<SparseLDLSolver name="linear"/>'}
for word in ("block_jacobi", "incomplete_cholesky", "multigrid"):
    GRID[word] = PRODUCTS.format(word, "CompressedRowSparseMatrixMat3x3")
for word in ("block_jacobi", "multigrid"):
    GRID[word + ", by products"] = PRODUCTS.format(word, "GraphScattered")
GRID["warped"] = PRODUCTS.format("warped", "auto") + '<SparseLDLSolver name="factors"/>'


def variants(scene):
    """Name of a solver: text of the scene with it."""
    found = {"": scene.text("")}
    for name, solver in GRID.items():
        if name in scene.without:
            continue
        found[name] = scene.text(solver)
        if name != "SparseLDLSolver" and scene.forcing(0.1):
            found[name + ", forcing 0.1"] = scene.text(solver, 0.1)
    return found


def lists(file):
    """What `stroma run --measure` has written: name -> numbers."""
    data = open(file, "rb").read()
    at, found = data.index(b"\n") + 1, {}
    while data[at:at + 4] != b"end\n" or at + 4 < len(data):
        kind, length = data[at:at + 1], struct.unpack_from("<q", data, at + 1)[0]
        name = data[at + 9:at + 9 + length].decode()
        at += 9 + length
        count = struct.unpack_from("<q", data, at)[0]
        at += 8
        width = {b"d": "d", b"i": "q", b"t": None}[kind]
        if width is None:
            for _ in range(count):
                at += 8 + struct.unpack_from("<q", data, at)[0]
            continue
        found[name] = struct.unpack_from(f"<{count}{width}", data, at)
        at += count * struct.calcsize(width)
    return found


class Run:
    def __init__(self, stroma, folder, scene, name, text, threads, longest):
        file, end = os.path.join(folder, scene.name + ".xml"), os.path.join(folder, "end")
        with open(file, "w") as out:
            out.write(text)
        command = [*shlex.split(stroma), "run", file, "-n", str(scene.steps), "--no-record", "--json", "-", "--quiet",
                   "--threads", str(threads), "--measure", end]
        bound = (lambda: resource.setrlimit(resource.RLIMIT_CPU, (int(longest) + 1, int(longest) + 1))) if longest else None
        with open(os.path.join(folder, "json"), "w") as out, open(os.path.join(folder, "errors"), "w") as errors:
            process = subprocess.Popen(command, stdout=out, stderr=errors, preexec_fn=bound)
            _, status, used = os.wait4(process.pid, 0)
        process.returncode = status
        self.seconds, self.end, self.summary = used.ru_utime + used.ru_stime, None, {}
        self.stopped = os.WIFSIGNALED(status)
        self.done = status == 0
        if self.done:
            written = open(os.path.join(folder, "json")).read()
            self.summary = json.loads(written[written.index("{"):])
            self.end = {k: v for k, v in lists(end).items() if k.startswith(("rest ", "x "))}
        elif not self.stopped:
            self.why = open(os.path.join(folder, "errors")).read().strip().split("\n")[-1]

    def counts(self):
        linear, newton = self.summary.get("linear", {}), self.summary.get("newton", {})
        return (f"{linear.get('iterations', 0)} iterations, {linear.get('factorisations', 0)} factorisations, "
                f"Newton {newton.get('iterations', 0)}")


def distance(a, b):
    """Of end positions, the largest over the largest displacement."""
    far = wide = 0.0
    for name, positions in a.items():
        if not name.startswith("x "):
            continue
        rest = a.get("rest " + name[2:], positions)
        far = max([far] + [abs(p - q) for p, q in zip(positions, b[name])])
        wide = max([wide] + [abs(p - q) for p, q in zip(positions, rest)])
    return far / wide if wide else far


def measure(scene, asked, folder):
    grid = [g.strip() for g in asked.grid.split(";") if g.strip()]
    texts = {n: t for n, t in variants(scene).items() if not grid or not n or n.replace(", forcing 0.1", "") in grid}
    times = {name: [] for name in texts}
    first = {}
    for turn in range(asked.rounds):
        for name, text in texts.items():
            own = times[""]
            if turn and name and (not times[name] or times[name][0] > 1.5 * min(t[0] for n, t in times.items() if n and t)):
                continue
            run = Run(asked.stroma, folder, scene, name, text, asked.threads, max(3 * own[0], own[0] + 2) if own and name else 0)
            if run.done:
                times[name].append(run.seconds)
                first.setdefault(name, run)
            elif not turn and not run.stopped:
                print(f"    {scene.name}, {name or 'nothing named'}: {run.why}", file=sys.stderr)
            if asked.verbose:
                said = run.counts() if run.done else "stopped"
                print(f"    {name or 'nothing named':44} {run.seconds:7.2f} {said}", flush=True)
    medians = {name: statistics.median(t) for name, t in times.items() if t}
    named = {name: t for name, t in medians.items() if name}
    if "" not in medians or not named:
        return None
    best = min(named, key=named.get)
    exact = first["SparseLDLSolver" if "SparseLDLSolver" in first else best]
    return medians[""], best, named[best], distance(first[""].end, exact.end)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--set", choices=("standing", "fresh", "late", "held", "unseen", "kinds", "mixed", "further", "all"), default="all")
    parser.add_argument("--only", default="", metavar="NAME,NAME")
    parser.add_argument("--grid", default="", metavar="NAME;NAME", help="of the named solvers these alone: " + "; ".join(GRID))
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--stroma", default="stroma", metavar="COMMAND")
    parser.add_argument("--limit", type=float, default=0)
    parser.add_argument("--keep", default="", metavar="DIR", help="write the scenes there and run nothing")
    parser.add_argument("--verbose", action="store_true", help="every run")
    asked = parser.parse_args()
    names = [n for n in asked.only.split(",") if n]
    scenes = [s for s in solver_scenes.scenes() if (s.name in names if names else asked.set in ("all", s.set))]
    if len(names) > len(scenes):
        parser.error("there are the scenes " + ", ".join(s.name for s in solver_scenes.scenes()))
    if asked.keep:
        os.makedirs(asked.keep, exist_ok=True)
        for scene in scenes:
            for name, text in variants(scene).items():
                word = name.replace(", ", "-").replace(" ", "_") or "none"
                with open(os.path.join(asked.keep, f"{scene.name}.{word}.xml"), "w") as out:
                    out.write(text)
        return 0
    worst = 0.0
    print("| scene | set | nothing named [s] | best named [s] | | ratio | apart |\n|---|---|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for scene in scenes:
            found = measure(scene, asked, folder)
            if not found:
                print(f"| {scene.name} | {scene.set} | no result |", flush=True)
                worst = float("inf")
                continue
            own, best, least, apart = found
            worst = max(worst, own / least)
            print(f"| {scene.about} (`{scene.name}`) | {scene.set} | {own:.2f} | {least:.2f} | {best} | {own / least:.2f} | "
                  f"{apart:.0e} |", flush=True)
    return 1 if asked.limit and worst > asked.limit else 0


if __name__ == "__main__":
    sys.exit(main())
