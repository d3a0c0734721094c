#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads traces of `stroma run --profile` as Perfetto does, and holds them to what they promise: spans of a thread lie within one
another to the nanosecond and stand in the order in which they begin, what they take by themselves adds up to the one that holds
all, each kind of work has its span under the right one, and steps, iterations and allocations are those of the run. The table
says what the trace says, all threads are heard, listening takes no memory that it then counts, and no bit is another one.
Nothing of this depends on how long anything takes.

Usage: trace.py STROMA                     the test
       trace.py STROMA SCENE.xml STEPS     the same for another scene; prints which share of the time has a name: a measurement"""
import copy
import json
import os
import re
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from processes import PATIENCE  # noqa: E402

TREE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
EXAMPLES = os.path.join(TREE, "scenes", "examples")
# They hold others, and say nothing of what is done.
HOLDERS = ("command", "run", "load", "whole step")
ALL_HEARD = 20  # steps, however short they are
# What stands in the trace of any run, each the only one of its kind under the one before it.
ONCE = (("command",), ("command", "load"), ("command", "load", "read the scene"), ("command", "load", "make components"),
        ("command", "load", "compile"), ("command", "load", "check the scene"), ("command", "run"), ("command", "end"),
        ("command", "put away"))


def nanoseconds(micro):
    return round(1000 * micro)


class Span:
    def __init__(self, event, holder):
        self.name, self.kind, self.arguments = event["name"], event["cat"], event.get("args", {})
        self.begin = nanoseconds(event["ts"])
        self.end = self.begin + nanoseconds(event["dur"])
        self.holder, self.within = holder, []
        self.path = (*holder.path, self.kind) if holder else (self.kind,)

    def took(self):
        return self.end - self.begin

    def itself(self):
        return self.took() - sum(span.took() for span in self.within)

    def all_within(self):
        for span in self.within:
            yield span
            yield from span.all_within()

    def taken(self):
        """Allocations without those of the spans within."""
        return self.arguments.get("allocations", 0) - sum(span.arguments.get("allocations", 0) for span in self.within)


class Thread:
    """The spans of one thread, in the order of the file; `outer` holds those that nothing holds."""

    def __init__(self, events):
        self.spans, self.outer, self.wrong = [], [], []
        open_spans, last = [], 0
        for event in events:
            begin = nanoseconds(event["ts"])
            if begin < last:
                self.wrong.append(f"{event} begins before the one that the file has before it")
            last = begin
            while open_spans and open_spans[-1].end <= begin and not (open_spans[-1].begin == begin and event["dur"] == 0):
                open_spans.pop()
            span = Span(event, open_spans[-1] if open_spans else None)
            if span.holder:
                span.holder.within.append(span)
                if span.end > span.holder.end:
                    self.wrong.append(f"{event} ends after {span.holder.name}, which holds it")
            else:
                self.outer.append(span)
            open_spans.append(span)
            self.spans.append(span)
        self.wrong += [f"what is in {span.name} is longer than it" for span in self.spans if span.itself() < 0]

    def count(self, *path):
        return sum(span.path == path for span in self.spans)


def threads_of(trace):
    spans = [event for event in trace["traceEvents"] if event["ph"] == "X"]
    return {number: Thread([e for e in spans if e["tid"] == number]) for number in sorted({e["tid"] for e in spans})}


def run(stroma, scene, steps, folder, *options):
    """The summary of a run, and what it says."""
    done = subprocess.run([stroma, "run", scene, "-n", str(steps), "--no-record", "--json=run.json", *options], cwd=folder,
                          capture_output=True, text=True, errors="replace", timeout=PATIENCE)
    if done.returncode:
        raise SystemExit(f"{scene} {options}: {done.stderr[-600:]}")
    with open(os.path.join(folder, "run.json"), encoding="utf-8") as file:
        return json.load(file), done.stderr


def profile(stroma, scene, steps, *options):
    """The trace of a run, its summary, and the table on standard error."""
    with tempfile.TemporaryDirectory() as folder:
        summary, table = run(stroma, scene, steps, folder, "--profile", "trace.json", *options)
        with open(os.path.join(folder, "trace.json"), encoding="utf-8") as file:
            return json.load(file), summary, table


def named_of(thread):
    """Nanoseconds that have the name of what is done."""
    return sum(span.itself() for span in thread.spans if span.kind not in HOLDERS)


def wrong_times(trace):
    """What is wrong with when spans begin and end."""
    threads = threads_of(trace)
    for number, thread in threads.items():
        for sentence in thread.wrong[:3]:
            yield f"thread {number}: {sentence} ({len(thread.wrong)} of this kind)"
    steps = threads[1]
    if len(steps.outer) != 1:
        yield f"one span holds all others, not {[span.name for span in steps.outer]}"
    whole = sum(span.took() for span in steps.outer)
    if sum(span.itself() for span in steps.spans) != whole:
        yield f"the spans take {sum(span.itself() for span in steps.spans)} ns, the one that holds them {whole} ns"
    # listening begins before the first span and ends after the last one; both ends are rounded
    wall = 1e9 * trace["otherData"]["wall_seconds"]
    if whole > wall + 1 or any(span.begin < 0 or span.end > wall + 1 for thread in threads.values() for span in thread.spans):
        yield f"spans of {whole} ns in a run of {wall} ns"


def wrong_kinds(trace, summary, steps):
    """What has no span, or one at the wrong place."""
    thread = threads_of(trace)[1]
    for path in ONCE:
        if thread.count(*path) != 1:
            yield f"{thread.count(*path)} spans {' > '.join(path)}, expected one"
    order = [span.kind for span in thread.outer[0].within if span.kind in ("load", "run", "end", "put away")]
    if order != ["load", "run", "end", "put away"]:
        yield f"the parts of a run are {order}"
    each = [span for span in thread.spans if span.kind == "whole step"]
    if len(each) != steps or summary["steps"] != steps or any(span.path != ("command", "run", "whole step") for span in each):
        yield f"{steps} steps, and another number of spans for them: {len(each)}"
    if thread.count("command", "run", "record and tell") != steps:
        yield f"{thread.count('command', 'run', 'record and tell')} times something was told, in {steps} steps"
    for number, span in enumerate(each, 1):
        integrators = [inner for inner in span.within if inner.kind == "step"]
        if not integrators or any(sum(part.kind == "integrate" for part in inner.within) != 1 for inner in integrators):
            yield f"step {number} is {[inner.name for inner in span.all_within()][:12]}"
    if thread.count("command", "load", "make components", "open a module") < 1:
        yield "no module is opened"


def wrong_work(trace, summary):
    """Of a scene with an implicit step: each kind of work within the integration of each step, and of a component by its path."""
    thread = threads_of(trace)[1]
    within = ("command", "run", "whole step", "step", "integrate")
    for number, step in enumerate((span for span in thread.spans if span.path == within[:-1]), 1):
        parts = [span.kind for span in step.within]
        work = {span.kind for inner in step.within if inner.kind == "integrate" for span in inner.all_within()}
        if parts != ["begin step", "integrate", "end step"] or not {"force", "solve", "product"} <= work:
            yield f"step {number} is {parts} by {sorted(work)}"
    for path in ((*within, "force"), (*within, "solve"), (*within, "solve", "product"), within[:4],
                 ("command", "load", "make components", "init")):
        here = [span for span in thread.spans if span.path == path]
        owners = {span.arguments.get("of", "") for span in here}
        if not here or not all(owner.startswith("/") for owner in owners) or not linear_iterations(summary):
            yield f"{' > '.join(path)} is of {sorted(owners) or 'nobody'}"
        if any(span.name != f"{span.kind} {span.arguments.get('of')}" for span in here):
            yield f"a name of {' > '.join(path)} is not its kind and its owner"


def linear_iterations(summary):
    return summary.get("solvers", summary).get("linear", {}).get("iterations", 0)


def wrong_counts(trace, summary, steps):
    """Iterations and allocations."""
    thread = threads_of(trace)[1]
    found = sum(span.arguments.get("iterations", 0) for span in thread.spans)
    if found != linear_iterations(summary):
        yield f"{found} iterations in the trace, {linear_iterations(summary)} in the summary"
    drawn = sum(e["args"]["of a solve"] for e in trace["traceEvents"] if e["ph"] == "C" and e["name"] == "iterations")
    if drawn != found:
        yield f"a curve of {drawn} iterations, and {found} in spans"
    curve = [e["args"]["of a step"] for e in trace["traceEvents"] if e["ph"] == "C" and e["name"] == "allocations"]
    if not curve:  # a sanitizer counts none
        return
    if curve != [span.arguments.get("allocations", 0) for span in thread.spans if span.kind == "whole step"] or len(curve) != steps:
        yield f"the curve of allocations is {curve[:12]}"
    if any(span.taken() < 0 for span in thread.spans):
        yield "what is in a span takes more memory than it"
    if sum(span.arguments.get("allocations", 0) for span in thread.spans if span.kind == "load") < 1000:
        yield "a start takes memory"


def wrong_table(trace, table):
    """The table is of the same spans as the trace: calls, iterations and allocations by name, and the share with a name."""
    thread = threads_of(trace)[1]
    if trace["otherData"]["spans_in_the_table_alone"]:
        yield "the scene has more spans than a trace has room for"
    counts = {}
    for span in thread.spans:
        so_far = counts.setdefault(span.name, [0, 0, 0])
        for k, more in enumerate((1, span.arguments.get("iterations", 0), span.taken())):
            so_far[k] += more
    with_allocations = any(e["name"] == "allocations" for e in trace["traceEvents"])
    rows = 0
    for line in table.splitlines():
        row = re.match(r" *[0-9.]+% +\S+ \w+ +\S+ \w+ +(\d+) +(.*)$", line)
        if not row:
            continue
        rows += 1
        numbers, name = re.match(r"((?:\d+ +)*)(.*?)(?:, what has no name in it)?$", row.group(2)).groups()
        calls, iterations, taken = counts.get(name, (0, 0, 0))
        expected = [iterations] * (iterations > 0) + [taken] * with_allocations
        if int(row.group(1)) != calls or [int(number) for number in numbers.split()] != expected:
            yield f"the table says '{line}', the trace {calls} calls, {iterations} iterations, {taken} allocations"
    if rows != min(24, len(counts)):
        yield f"{rows} rows of {len(counts)} names in the table:\n{table}"
    shown = re.search(r"of wall time, ([0-9.]+) % with a name. Trace of (\d+) spans", table)
    wall = 1e9 * trace["otherData"]["wall_seconds"]
    spans = sum(event["ph"] == "X" for event in trace["traceEvents"])
    # one decimal is shown, and each end of a span is rounded to a nanosecond
    slack = 0.05 + 100 * (2 * spans + 1) / wall + 1e-6
    if not shown or abs(float(shown.group(1)) - 100 * named_of(thread) / wall) > slack or int(shown.group(2)) != spans:
        yield f"the table says {shown and shown.group(0)}, the trace {100 * named_of(thread) / wall:.2f} % and {spans} spans"


def wrong_threads(stroma):
    """What pieces loops have does not depend on the number of threads, and each is a span of the thread that did it."""
    scene, shares, heard = os.path.join(EXAMPLES, "leg.xml"), {}, set()
    for attempt in range(50):
        count = 2 + attempt % 2
        trace, _, _ = profile(stroma, scene, 3, "--threads", str(count), "-q")
        yield from wrong_times(trace)
        threads = threads_of(trace)
        shares[count] = sum(span.kind == "share" for thread in threads.values() for span in thread.spans)
        told = sum(e["ph"] == "M" and e["name"] == "thread_name" for e in trace["traceEvents"])
        if max(threads) > told:
            yield f"{told} threads are told of, and {sorted(threads)} have spans"
        heard |= set(threads)
        # that a second one gets a piece before the first has done all is nothing that a busy machine does each time
        if len(shares) == 2 and 2 in heard:
            break
    if len(set(shares.values())) != 1 or min(shares.values()) == 0:
        yield f"the number of pieces by the number of threads: {shares}"
    if 2 not in heard:
        yield "no second thread is heard"


def wrong_bits(stroma, scene, steps, summary):
    """The run is the one that nobody listens to, and its scene is not written over."""
    with tempfile.TemporaryDirectory() as folder:
        plain, _ = run(stroma, scene, steps, folder, "-q")
        for what in ("state_hash", "energies", "steps", "simulated_time"):
            if plain[what] != summary[what]:
                yield f"{what} is {summary[what]}, and {plain[what]} where nobody listens"
        refused = subprocess.run([stroma, "run", scene, "-n", "1", "--profile", scene], cwd=folder, capture_output=True, text=True,
                                 timeout=PATIENCE)
        if refused.returncode != 2 or "--profile" not in refused.stderr:
            yield f"it writes over its scene: {refused.stderr}"


def wrong_memory(stroma):
    """Steps that take no memory take none when somebody listens: its lists grow by themselves, and are not counted."""
    trace, _, _ = profile(stroma, os.path.join(EXAMPLES, "explicit.xml"), ALL_HEARD)
    if not any(event["name"] == "allocations" for event in trace["traceEvents"]):
        print("note: nobody counts allocations in this build")
        return
    steps = [event for event in trace["traceEvents"] if event["ph"] == "X" and event["cat"] == "step"]
    taken = [(k, e["args"]) for k, e in enumerate(steps) if k > 0 and e.get("args", {}).get("allocations")]
    if taken or len(steps) != ALL_HEARD:
        yield f"{len(taken)} of {len(steps)} steps of explicit.xml take memory, as {taken[:1]}"


def wrong_estimates(stroma):
    """Of short steps some are heard; how short they are is the machine's. What is counted in them is the same in each step of
    this scene, so that estimates are exact, however many were heard. Times add up to the whole: each has a place."""
    steps = 20 * ALL_HEARD
    trace, summary, table = profile(stroma, os.path.join(EXAMPLES, "explicit.xml"), steps)
    yield from wrong_times(trace)
    thread, other = threads_of(trace)[1], trace["otherData"]
    heard = thread.count("command", "run", "whole step")
    if other["steps"] != steps or other["steps_heard"] != heard or not ALL_HEARD <= heard <= steps or summary["steps"] != steps:
        yield f"{heard} of {steps} steps have spans, and the trace says {other}"
    if ("The steps are short" in table) != (heard < steps):
        yield f"{heard} of {steps} steps were heard, and the table is {table}"
    rows = re.findall(r"^ *[0-9.]+% +\S+ \w+ +\S+ \w+ +(\d+) [ \d]*([a-z][a-z ]*)", table, re.M)
    calls = {name: int(number) for number, name in rows}
    # rows that take too little are in one of "others"
    told = calls.get("record and tell", steps if re.search(r"\d+ others", table) else 0)
    if calls.get("whole step") != steps or told != steps:
        yield f"{steps} steps, of which the table knows {rows}"
    shares = [float(number) for number in re.findall(r"^ *([0-9.]+)% ", table, re.M)]
    if sum(shares) > 100 + 0.05 * len(shares):  # rounded; less by what lies before the first span and after the last
        yield f"the shares of the table are {sum(shares)} % together:\n{table}"


def wrong(trace, summary, table, steps):
    return [*wrong_times(trace), *wrong_kinds(trace, summary, steps), *wrong_counts(trace, summary, steps),
            *wrong_table(trace, table)]


def unnoticed(trace, summary, table, steps):
    """Faults that are put into a right trace, and that nothing is said of."""
    def at(damaged, kind):
        """The last span of this kind."""
        return [e for e in damaged["traceEvents"] if e["ph"] == "X" and e["tid"] == 1 and e["cat"] == kind][-1]

    def longer(damaged):
        at(damaged, "force")["dur"] += 1e6

    def by_a_nanosecond(damaged):
        last, whole = at(damaged, "put away"), at(damaged, "command")
        whole["dur"] = last["ts"] + last["dur"] - whole["ts"] - 0.001

    def out_of_order(damaged):
        events = damaged["traceEvents"]
        one, other = events.index(at(damaged, "load")), events.index(at(damaged, "run"))
        events[one], events[other] = events[other], events[one]

    def without(kind):
        return lambda damaged: damaged["traceEvents"].remove(at(damaged, kind))

    def fewer_iterations(damaged):
        at(damaged, "solve")["args"]["iterations"] -= 1

    def a_shorter_run(damaged):
        damaged["otherData"]["wall_seconds"] *= 0.9

    faults = {"a force that ends late": longer, "an end that is a nanosecond early": by_a_nanosecond, "another order": out_of_order,
              "another number of iterations": fewer_iterations, "a shorter run": a_shorter_run,
              **{f"no {kind}": without(kind) for kind in
                 ("whole step", "integrate", "step", "load", "read the scene", "solve", "put away")}}
    for name, damage in faults.items():
        damaged = copy.deepcopy(trace)
        damage(damaged)
        if not wrong(damaged, summary, table, steps):
            yield f"a trace with a fault is taken for a right one: {name}"


def main():
    stroma = os.path.abspath(sys.argv[1])
    scene = os.path.abspath(sys.argv[2]) if len(sys.argv) > 2 else os.path.join(EXAMPLES, "cantilever_svd.xml")
    steps = int(sys.argv[3]) if len(sys.argv) > 3 else 12
    trace, summary, table = profile(stroma, scene, steps)
    failures = wrong(trace, summary, table, steps)
    if len(sys.argv) > 2:
        thread, wall = threads_of(trace)[1], 1e9 * trace["otherData"]["wall_seconds"]
        print(f"{100 * named_of(thread) / wall:.1f} % of {wall / 1e9:.3f} s has the name of what is done; of what holds others:")
        for kind in HOLDERS:
            print(f"  {kind} {100 * sum(span.itself() for span in thread.spans if span.kind == kind) / wall:.1f} %")
    else:
        failures += [*wrong_work(trace, summary), *wrong_bits(stroma, scene, steps, summary)]
        failures += [] if failures else unnoticed(trace, summary, table, steps)
        liver = os.path.join(EXAMPLES, "liver.xml")
        failures += [f"liver.xml: {failure}" for failure in wrong(*profile(stroma, liver, 20), 20)]
        failures += [*wrong_threads(stroma), *wrong_memory(stroma), *wrong_estimates(stroma)]
    for failure in failures:
        print(failure)
    print(f"{len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
