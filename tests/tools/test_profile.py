#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""A trace of `stroma run --profile`: spans are nested, their sums are the whole, iterations and allocations are those of the
run, threads are there, and no bit of the run is another one. Usage: test_profile.py TREE STROMA"""
import json
import os
import re
import subprocess
import sys
import tempfile

TREE, STROMA = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
SCENE = os.path.join(TREE, "scenes", "examples", "organ.xml")
failures = []


def expect(truth, text):
    if not truth:
        failures.append(text)


def run(folder, *arguments, scene=SCENE):
    done = subprocess.run([STROMA, "run", scene, *arguments], cwd=folder, capture_output=True, text=True, errors="replace")
    expect(done.returncode == 0, f"{arguments}: {done.stderr[-500:]}")
    return done


def nested(spans):
    """Self times by span; says where two spans of a thread cross."""
    stack, own = [], {}
    for span in sorted(spans, key=lambda e: (e["ts"], -e["dur"])):
        while stack and span["ts"] >= stack[-1]["ts"] + stack[-1]["dur"] - 2e-3:
            stack.pop()
        if stack:
            expect(span["ts"] + span["dur"] <= stack[-1]["ts"] + stack[-1]["dur"] + 2e-3, f"{span} crosses {stack[-1]}")
            own[stack[-1]["name"]] -= span["dur"]
        own[span["name"]] = own.get(span["name"], 0) + span["dur"]
        stack.append(span)
    return own


def profiled(folder):
    """What the command says, its trace, and the share of the wall time that has a name. Another process may take the processor
    between two spans, so that of several runs the one counts in which that did not happen."""
    for _ in range(8):
        table = run(folder, "-n", "12", "--json=run.json", "--profile", "trace.json", "--no-record").stderr
        with open(os.path.join(folder, "trace.json"), encoding="utf-8") as file:
            trace = json.load(file)
        own = nested([e for e in trace["traceEvents"] if e["ph"] == "X" and e["tid"] == 1])
        wall = 1e6 * trace["otherData"]["wall_seconds"]
        named = sum(time for name, time in own.items() if name not in ("command", "run", "load", "whole step")) / wall
        if named > 0.95 and abs(sum(own.values()) - wall) < 0.02 * wall + 2000:
            break
    return table, trace, named


def main():
    with tempfile.TemporaryDirectory() as folder:
        plain = run(folder, "-n", "12", "--json", "-q", "--no-record")
        table, trace, named = profiled(folder)
        with open(os.path.join(folder, "run.json"), encoding="utf-8") as file:
            summary = json.load(file)
        events = trace["traceEvents"]
        spans = [e for e in events if e["ph"] == "X" and e["tid"] == 1]
        own = nested(spans)
        wall = 1e6 * trace["otherData"]["wall_seconds"]
        expect(named > 0.95, f"{100 * named:.1f} % of the wall time has a name")
        expect(abs(sum(own.values()) - wall) < 0.02 * wall + 2000, f"spans take {sum(own.values())} of {wall}")
        expect(sum(1 for e in spans if e["name"] == "whole step") == 12, "a span for each step")
        by_component = [e for e in spans if e.get("args", {}).get("of", "").startswith("/")]
        for what in ("force", "product", "solve", "integrate", "init"):
            expect(any(e["cat"] == what for e in by_component), f"no {what} of a component")
        iterations = sum(e.get("args", {}).get("iterations", 0) for e in spans)
        linear = summary["solvers"]["linear"]["iterations"] if "solvers" in summary else summary["linear"]["iterations"]
        expect(iterations == linear, f"{iterations} iterations in the trace, {linear} in the summary")
        counters = [e for e in events if e["ph"] == "C" and e["name"] == "allocations"]
        if counters:  # a sanitizer counts none
            expect(all(e["args"]["of a step"] >= 0 for e in counters) and len(counters) == 12, "allocations of each step")
            expect(sum(e.get("args", {}).get("allocations", 0) for e in spans if e["name"] == "load") > 1000, "allocations of the start")
        match = re.search(r"of wall time, ([0-9.]+) % with a name", table)
        expect(match and abs(float(match.group(1)) - 100 * named) < 1, f"the table says otherwise: {table[-300:]}")
        # bits are the same, and nothing of the profile is left in the environment of others
        hashes = [json.loads(plain.stdout).get("state_hash"), summary.get("state_hash")]
        expect(hashes[0] == hashes[1], f"state hashes {hashes}")
        expect(json.loads(plain.stdout)["energies"] == summary["energies"], "energies differ")
        threaded = run(folder, "-n", "3", "--threads", "2", "--profile", "two.json", "--no-record", "-q",
                       scene=os.path.join(TREE, "scenes", "examples", "leg.xml"))
        expect(threaded.returncode == 0, threaded.stderr[-300:])
        with open(os.path.join(folder, "two.json"), encoding="utf-8") as file:
            two = [e for e in json.load(file)["traceEvents"] if e["ph"] == "X"]
        expect({1, 2} <= {e["tid"] for e in two}, "spans of two threads")
        nested([e for e in two if e["tid"] == 2])
        refused = subprocess.run([STROMA, "run", SCENE, "-n", "1", "--profile", SCENE], cwd=folder, capture_output=True, text=True)
        expect(refused.returncode == 2 and "--profile" in refused.stderr, f"writes over its scene: {refused.stderr}")
    for text in failures:
        print(text)
    print(f"{len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
