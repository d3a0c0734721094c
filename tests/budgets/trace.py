#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads profiles of example scenes as Perfetto does, and holds them to what they promise: spans of a thread lie within one
another to the nanosecond and stand in the order in which they begin, what they take by themselves adds up to the wall time, 95 %
of it has a name, and listening takes no memory that it then counts. Usage: trace.py STROMA [SCENE.xml STEPS]"""
import json
import os
import re
import subprocess
import sys
import tempfile

TREE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# They hold others, and say nothing of what is done.
HOLDERS = ("command", "run", "load", "whole step")


def nanoseconds(micro):
    return round(1000 * micro)


class Thread:
    """The spans of one thread, in the order of the file."""

    def __init__(self, events):
        self.own, self.crossed, self.late, stack, last = {}, [], [], [], 0
        for event in events:
            begin, end = nanoseconds(event["ts"]), nanoseconds(event["ts"]) + nanoseconds(event["dur"])
            if begin < last:
                self.late.append(event)
            last = begin
            while stack and stack[-1][1] <= begin and not (stack[-1][0] == begin == end):
                stack.pop()
            if stack:
                if end > stack[-1][1]:
                    self.crossed.append((event, stack[-1][2]))
                self.own[stack[-1][2]] -= end - begin
            name = event["name"]
            self.own[name] = self.own.get(name, 0) + end - begin
            stack.append((begin, end, name))


def profile(stroma, scene, steps, folder):
    done = subprocess.run([stroma, "run", scene, "-n", str(steps), "--profile", "trace.json", "--no-record"], cwd=folder,
                          capture_output=True, text=True, errors="replace", timeout=250)
    if done.returncode:
        raise SystemExit(f"{scene}: {done.stderr[-600:]}")
    with open(os.path.join(folder, "trace.json"), encoding="utf-8") as file:
        return json.load(file), done.stderr


def check_times(stroma, scene, steps):
    """What is wrong with the times of one profile."""
    with tempfile.TemporaryDirectory() as folder:
        trace, table = profile(stroma, scene, steps, folder)
    spans = [e for e in trace["traceEvents"] if e["ph"] == "X"]
    wall = 1e9 * trace["otherData"]["wall_seconds"]
    for number in sorted({e["tid"] for e in spans}):
        thread = Thread([e for e in spans if e["tid"] == number])
        if thread.crossed:
            yield f"thread {number}: {len(thread.crossed)} spans end after what holds them, as {thread.crossed[0]}"
        if thread.late:
            yield f"thread {number}: {len(thread.late)} spans begin before the one that the file has before them"
    own = Thread([e for e in spans if e["tid"] == 1]).own
    if min(own.values()) < 0:
        yield f"what is in a span is longer than it: {own}"
    if abs(sum(own.values()) - wall) > 0.01 * wall:
        yield f"the spans are {sum(own.values()) / 1e9:.4f} s, the run took {wall / 1e9:.4f} s"
    named = sum(time for name, time in own.items() if name not in HOLDERS)
    if named < 0.95 * wall:
        rest = ", ".join(f"{name} {100 * own.get(name, 0) / wall:.1f} %" for name in HOLDERS)
        yield f"{100 * named / wall:.1f} % of the wall time has the name of what is done; of what only holds others: {rest}"
    shown = re.search(r"of wall time, ([0-9.]+) % with a name", table)
    if not shown or abs(float(shown.group(1)) - 100 * named / wall) > 0.2:
        yield f"the table says {shown and shown.group(1)} %, and the trace {100 * named / wall:.1f} %"
    if sum(e["name"] == "whole step" for e in spans) != steps:
        yield f"{steps} steps, and another number of spans for them"
    print(f"{os.path.basename(scene)}: {len(spans)} spans, {100 * named / wall:.1f} % of {wall / 1e9:.3f} s has a name")


def check_memory(stroma):
    """Steps that take no memory take none when somebody listens: its lists grow by themselves, and are not counted."""
    with tempfile.TemporaryDirectory() as folder:
        trace, _ = profile(stroma, os.path.join(TREE, "scenes", "examples", "explicit.xml"), 2000, folder)
    steps = [e for e in trace["traceEvents"] if e["ph"] == "X" and e["name"].startswith("step ")]
    taken = [(k, e["args"]) for k, e in enumerate(steps) if k > 0 and e.get("args", {}).get("allocations")]
    if taken:
        yield f"{len(taken)} of {len(steps)} steps of explicit.xml take memory, as step {taken[0][0] + 1}: {taken[0][1]}"


def main():
    stroma = os.path.abspath(sys.argv[1])
    if len(sys.argv) > 2:
        failures = list(check_times(stroma, os.path.abspath(sys.argv[2]), int(sys.argv[3])))
    else:
        liver = os.path.join(TREE, "scenes", "examples", "liver.xml")
        for _ in range(6):
            failures = list(check_times(stroma, liver, 60))
            # another process may take the processor between two spans: a share of time is judged where that did not happen
            if not failures or not all("of the wall time" in failure or "the run took" in failure for failure in failures):
                break
        failures += check_memory(stroma)
    for failure in failures:
        print(failure)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
