#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""How near the solver that nobody named comes to the best that could be named.

    tools/bench/solver_choice.py                              all sets
    tools/bench/solver_choice.py --set fresh --rounds 3
    tools/bench/solver_choice.py --only arch,dice --stroma build/release/bin/stroma
    tools/bench/solver_choice.py --out docs/experiments/solver_choice.csv
    tools/bench/solver_choice.py --table docs/experiments/solver_choice.csv

Each scene of solver_scenes.py runs without a linear solver and with each of the grid, in turns: user and system processor time of the
whole command on one thread, medians of their sums. A run is stopped when it has taken three times as long as nothing named. After the
first round only those go on that are within 1.3 of the best. All scenes are measured by this rule, whatever their ratio. Newton's
method with a named solver by products counts with its usual forcing term and with 0.1, whichever is faster. Printed are the ratio to
the best named, and how far the end positions of nothing named are from those of the most exact of the grid, relative to the largest
displacement. `within` is how far they may be, ten times the tolerance of the scene. `grid` is the largest such distance between two of
the named ones: where it is larger, the scene has several answers, or tells them badly apart.

--out writes a row for each scene, and replaces those of scenes that were there before. --table prints from such a file the rows of
docs/scale.md. --limit ends with 1 when a ratio is above it, or an answer is farther than `within`."""
import argparse
import collections
import csv
import json
import os
import re
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
        self.user, self.system, self.faults = used.ru_utime, used.ru_stime, used.ru_minflt
        self.seconds, self.end, self.summary = self.user + self.system, None, {}
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


def within(scene):
    """How far apart answers may be."""
    told = re.search(r'(?:newtonTolerance|relative_residual_tolerance_threshold)="([^"]*)"', scene.text(""))
    return 10 * (float(told.group(1)) if told else 1e-8)


class Result:
    """Of a scene: the median runs of nothing named and of the best named."""
    FIELDS = ("set", "scene", "nodes_and_kind", "user", "system", "page_faults", "best_user", "best_system", "best_page_faults", "best",
              "ratio", "ratio_of_user_time", "apart", "within", "apart_in_grid", "rounds", "load", "counts", "counts_of_best")

    def __init__(self, scene, runs, ends, load):
        middle = {n: sorted(r, key=lambda run: run.seconds)[(len(r) - 1) // 2] for n, r in runs.items() if r}
        self.best = min((n for n in middle if n), key=lambda n: statistics.median(r.seconds for r in runs[n]))
        self.scene, self.rounds, self.load, self.own, self.other = scene, len(runs[""]), load, middle[""], middle[self.best]
        self.ratio, self.user_ratio = (statistics.median(map(f, runs[""])) / statistics.median(map(f, runs[self.best]))
                                       for f in (lambda run: run.seconds, lambda run: run.user))
        exact = "SparseLDLSolver" if "SparseLDLSolver" in ends else self.best
        self.apart = distance(ends[""], ends[exact])
        self.within = within(scene)
        named = [end for name, end in ends.items() if name]
        self.grid = max(distance(a, b) for a in named for b in named)

    def row(self):
        own, best = self.own, self.other
        return dict(zip(self.FIELDS, (
            self.scene.set, self.scene.name, self.scene.about, f"{own.user:.3f}", f"{own.system:.3f}", own.faults, f"{best.user:.3f}",
            f"{best.system:.3f}", best.faults, self.best, f"{self.ratio:.3f}", f"{self.user_ratio:.3f}", f"{self.apart:.1e}",
            f"{self.within:.1e}", f"{self.grid:.1e}", self.rounds, f"{self.load:.1f}", own.counts(), best.counts())))


def measure(scene, asked, folder):
    grid = [g.strip() for g in asked.grid.split(";") if g.strip()]
    texts = {n: t for n, t in variants(scene).items() if not grid or not n or n.replace(", forcing 0.1", "") in grid}
    runs, ends = {name: [] for name in texts}, {}
    for turn in range(asked.rounds):
        for name, text in texts.items():
            own = runs[""]
            if turn and name and (not runs[name] or runs[name][0].seconds > 1.3 * min(r[0].seconds for n, r in runs.items() if n and r)):
                continue
            run = Run(asked.stroma, folder, scene, name, text, asked.threads,
                      max(3 * own[0].seconds, own[0].seconds + 2) if own and name else 0)
            if run.done:
                runs[name].append(run)
                ends.setdefault(name, run.end)
            elif not turn and not run.stopped:
                print(f"    {scene.name}, {name or 'nothing named'}: {run.why}", file=sys.stderr)
            if asked.verbose:
                said = run.counts() if run.done else "stopped"
                print(f"    {name or 'nothing named':44} {run.user:7.2f} + {run.system:5.2f} {said}", flush=True)
    if not runs[""] or not any(r for name, r in runs.items() if name):
        return None
    return Result(scene, runs, ends, os.getloadavg()[0])


def read(file):
    if not os.path.exists(file):
        return []
    with open(file, newline="") as rows:
        return list(csv.DictReader(rows))


def write(file, rows):
    order = {(s.set, s.name): k for k, s in enumerate(solver_scenes.scenes())}
    rows = sorted(rows, key=lambda row: order.get((row["set"], row["scene"]), len(order)))
    with open(file, "w", newline="") as out:
        table = csv.DictWriter(out, Result.FIELDS, lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def print_table(rows, limit=1.15):
    """The rows of docs/scale.md."""
    of = collections.Counter(scene.set for scene in solver_scenes.scenes())
    total, good = 0, 0
    print(f"| set | measured | within {limit} | lowest | above |\n|---|---|---|---|---|")
    for name in dict.fromkeys(row["set"] for row in rows):
        own = [row for row in rows if row["set"] == name]
        above = sorted((row for row in own if float(row["ratio"]) > limit), key=lambda row: -float(row["ratio"]))
        total, good = total + len(own), good + len(own) - len(above)
        words = ", ".join(f"`{row['scene']}` {float(row['ratio']):.2f}" for row in above)
        least = min(float(row["ratio"]) for row in own)
        print(f"| `{name}` | {len(own)} of {of[name]} | {len(own) - len(above)} | {least:.2f} | {words} |")
    apart = [f"`{row['scene']}`" for row in rows if float(row["apart"]) > float(row["within"])]
    print(f"| all | {total} of {of.total()} | {good} | {min(float(row['ratio']) for row in rows):.2f} | {total - good} |\n\n"
          f"Answers farther apart than ten times the tolerance: {', '.join(apart) or 'none'}.")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--set", choices=(*dict.fromkeys(s.set for s in solver_scenes.scenes()), "all"), default="all")
    parser.add_argument("--only", default="", metavar="NAME,NAME")
    parser.add_argument("--grid", default="", metavar="NAME;NAME", help="of the named solvers these alone: " + "; ".join(GRID))
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--stroma", default="stroma", metavar="COMMAND")
    parser.add_argument("--limit", type=float, default=0)
    parser.add_argument("--out", default="", metavar="FILE.csv", help="add the rows there")
    parser.add_argument("--table", default="", metavar="FILE.csv", help="print how many are within --limit (1.15) and run nothing")
    parser.add_argument("--keep", default="", metavar="DIR", help="write the scenes there and run nothing")
    parser.add_argument("--verbose", action="store_true", help="every run")
    asked = parser.parse_args()
    if asked.table:
        print_table(read(asked.table), asked.limit or 1.15)
        return 0
    names = [n for n in asked.only.split(",") if n]
    scenes = [s for s in solver_scenes.scenes() if (s.name in names if names else asked.set in ("all", s.set))]
    if set(names) - {s.name for s in scenes}:
        parser.error("there are the scenes " + ", ".join(s.name for s in solver_scenes.scenes()))
    if asked.keep:
        os.makedirs(asked.keep, exist_ok=True)
        for scene in scenes:
            for name, text in variants(scene).items():
                word = name.replace(", ", "-").replace(" ", "_") or "none"
                with open(os.path.join(asked.keep, f"{scene.name}.{word}.xml"), "w") as out:
                    out.write(text)
        return 0
    bad = 0
    print("| scene | set | nothing named: user, system [s] | best named | | ratio | of user time | apart | within | grid |\n"
          + 10 * "|---" + "|", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for scene in scenes:
            found = measure(scene, asked, folder)
            if not found:
                print(f"| {scene.name} | {scene.set} | no result |", flush=True)
                bad += 1
                continue
            bad += found.ratio > asked.limit or found.apart > found.within
            own, best = found.own, found.other
            print(f"| {scene.about} (`{scene.name}`) | {scene.set} | {own.user:.2f}, {own.system:.2f} | {best.user:.2f}, {best.system:.2f} "
                  f"| {found.best} | {found.ratio:.2f} | {found.user_ratio:.2f} | {found.apart:.0e} | {found.within:.0e} "
                  f"| {found.grid:.0e} |", flush=True)
            if asked.out:
                row = found.row()
                write(asked.out, [r for r in read(asked.out) if (r["set"], r["scene"]) != (row["set"], row["scene"])] + [row])
    return 1 if asked.limit and bad else 0


if __name__ == "__main__":
    sys.exit(main())
