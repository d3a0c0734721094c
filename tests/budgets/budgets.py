#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Holds example scenes to what a start and a step of theirs may cost: calls, allocations and bytes of each component, modules
that are opened, instructions by function. What is stored belongs to a compiler, an instruction set and a processor:
on another machine instructions, bytes, and calls that a machine chooses by its speeds are not compared, all else is.

Usage: budgets.py STROMA [--update] [--scenes NAME...]      hold scenes to stored.json, or write it anew
       budgets.py STROMA --self-test                        waste is planted, and must be found by its name
       budgets.py STROMA --idle                             what nobody reads costs nothing
Exit codes: 0 all within, 1 something costs more."""
import argparse
import bisect
import functools
import hashlib
import json
import os
import platform
import re
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
TREE = os.path.dirname(os.path.dirname(HERE))
STORED = os.path.join(HERE, "stored.json")
STEPS = 4
# Scenes whose instructions are counted: small ones. In a virtual machine that is itself in one, a processor that stops after
# each instruction does fifty thousand a second.
COUNTED = ["explicit", "partial_fixed"]
GROWTH = 0.003        # of the instructions of a step
ASKING = 1500         # instructions in which each part is asked whether it has something to do
START_GROWTH = 0.02   # of a start: it reads paths, which have lengths
OTHER_GROWTH = 0.05   # of calls where iterations may differ in the last digits
LONGEST = 1800        # seconds of one run: only what hangs takes so long
ITERATED = ("solve", "force", "share", "map")
CHOSEN = ("product", "assemble")  # a machine's speeds decide between the two


def test_module(stroma, name):
    """A module of tests in the build folder of a command."""
    return os.path.join(os.path.dirname(os.path.dirname(stroma)), "lib", "test_modules", name + ".so")


def command(stroma, scene, arguments, folder, **environment):
    words = [stroma, "run", scene, "--no-record", "--quiet", *arguments]
    try:
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, errors="replace", timeout=LONGEST,
                              env={**os.environ, **environment})
    except subprocess.TimeoutExpired as error:
        raise RuntimeError(f"{' '.join(words)}: not done after {LONGEST} s") from error
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(words)}: {done.stderr[-600:]}")


def tree_of(events):
    """The spans of the stepping thread, with what they allocate by themselves and the step they are in (0: before)."""
    spans = sorted((e for e in events if e.get("ph") == "X" and e["tid"] == 1), key=lambda e: (e["ts"], -e["dur"]))
    open_spans, out, step = [], [], 0
    for span in spans:
        while open_spans and span["ts"] >= open_spans[-1]["ts"] + open_spans[-1]["dur"] - 5e-4:
            open_spans.pop()
        for kind in ("allocations", "bytes"):
            span["own " + kind] = span.get("args", {}).get(kind, 0)
            if open_spans:
                open_spans[-1]["own " + kind] -= span["own " + kind]
        if span["name"] == "whole step":
            step += 1
        inside = span["name"] == "whole step" or any(s["name"] == "whole step" for s in open_spans)
        span["step"] = step if inside else 0
        open_spans.append(span)
        out.append(span)
    return out


def profile(stroma, scene, arguments=()):
    """Calls and allocations by name, of the steps after the first and of the start; modules."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:  # bytes of paths are counted
        command(stroma, scene, ["-n", str(STEPS), "--profile", "trace.json", "--json=run.json", *arguments], folder)
        with open(os.path.join(folder, "trace.json"), encoding="utf-8") as file:
            trace = json.load(file)
        with open(os.path.join(folder, "run.json"), encoding="utf-8") as file:
            modules = json.load(file)["modules_opened"]
    calls, taken, inits, start = {}, {"allocations": {}, "bytes": {}}, {}, {}
    for span in tree_of(trace["traceEvents"]):
        if span["step"] > 1:
            calls[span["name"]] = calls.get(span["name"], 0) + 1
            for kind, counts in taken.items():
                if span["own " + kind]:
                    counts[span["name"]] = counts.get(span["name"], 0) + span["own " + kind]
        elif span["step"] == 0 and span["cat"] in ("init", "open a module"):
            inits[span["name"]] = inits.get(span["name"], 0) + 1
        if span["name"] == "load":
            start = {kind: span.get("args", {}).get(kind, 0) for kind in taken}
    return {"modules": sorted(modules), "calls": calls, "inits": inits, **taken, "start": start}


@functools.cache
def functions_of(library):
    """Where the functions of a library begin, ascending, and their names."""
    found = {}
    for table in ([], ["-D"]):  # of all, and where these are stripped of those that others call
        listed = subprocess.run(["nm", "-C", "--defined-only", *table, library], capture_output=True, text=True, errors="replace").stdout
        for line in listed.splitlines():
            at, kind, name = line.split(" ", 2)
            if kind in "tTwWiu":
                found.setdefault(int(at, 16), name)
    return sorted(found), found


def instructions(stroma, scene, arguments=()):
    """Of one step, by function: the module waste stops after each instruction."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:  # bytes of paths are counted
        command(stroma, scene, ["-n", str(STEPS), "--module", test_module(stroma, "waste"), *arguments], folder, STROMA_COUNT="counts",
                OPENBLAS_NUM_THREADS="1")
        if not os.path.exists(os.path.join(folder, "counts")):
            raise RuntimeError(f"{scene}: no instructions were counted")
        functions = {}
        with open(os.path.join(folder, "counts"), encoding="utf-8", errors="replace") as file:
            for line in file:
                count, offset, library = line.rstrip("\n").split(" ", 2)
                if "vdso" in library or library == "nowhere" or os.path.basename(library).startswith("libc.so"):
                    continue  # the clock depends on the machine, how memory is copied on where it lies; allocations are counted apart
                begins, names = functions_of(library)
                k = bisect.bisect_right(begins, int(offset))
                name = names[begins[k - 1]] if k else os.path.basename(library)
                functions[name] = functions.get(name, 0) + int(count)
    step = sum(functions.values())
    if step < ASKING:
        raise RuntimeError(f"{scene}: {step} instructions are no step: this processor counts none")
    return {"step": step, "functions": functions}


def environment(stroma):
    lines = subprocess.run([stroma, "--version"], capture_output=True, text=True).stdout.splitlines()
    version = "; ".join(line for line in lines if line.startswith(("compiled", "libraries")))
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            cpu = file.readlines()
    except OSError:
        cpu = []
    libc = " ".join(platform.libc_ver())
    # functions of the C library come in variants, of which it takes one by the processor
    model, flags = (next((line.split(":")[1].strip() for line in cpu if line.startswith(what)), "") for what in ("model name", "flags"))
    processor = f"{model} {hashlib.sha256(flags.encode()).hexdigest()[:12]}"
    built = sorted(f for f in os.listdir(os.path.join(os.path.dirname(stroma), "..", "lib", "stroma")) if f.startswith("x86-64"))
    return {"version": version, "processor": processor, "libc": libc, "levels": built}


def measure(stroma, name):
    scene = os.path.join(TREE, "scenes", "examples", name + ".xml")
    found = profile(stroma, scene)
    if name in COUNTED:
        counted = instructions(stroma, scene)
        largest = sorted(counted["functions"].items(), key=lambda item: -item[1])[:40]
        found["instructions"] = {"step": counted["step"], "functions": dict(largest)}
    return found


def grown(what, now, before, tolerance):
    """Sentences on numbers by name that have grown."""
    for name in sorted(set(now) | set(before)):
        a, b = before.get(name, 0), now.get(name, 0)
        if b > a * (1 + tolerance):
            yield f"{what} of {name}: {b}, the budget is {a}"


def compare(now, before, same_machine):
    """What costs more than it did, each with its name."""
    found = [f"the module {module} is opened" for module in now["modules"] if module not in before["modules"]]
    # writers of files format names and numbers: the same wherever the folder is called alike
    written, own = ({n: c for n, c in now["allocations"].items() if n.startswith("observe") == is_writer} for is_writer in (True, False))
    # rounds of an iteration take memory too, and their number may differ in the last digits
    growth = 0 if same_machine else OTHER_GROWTH
    found += grown("allocations in steps", own, {n: before["allocations"].get(n, 0) for n in own}, growth)
    found += grown("allocations in steps", written, {n: before["allocations"].get(n, 0) for n in written}, OTHER_GROWTH)
    found += grown("calls at the start", now["inits"], before["inits"], 0)
    for name, count in now["calls"].items():
        if not same_machine and name.split()[0] in CHOSEN:
            continue
        budget = before["calls"].get(name, 0)
        slack = 0 if same_machine or name.split()[0] not in ITERATED else OTHER_GROWTH
        if count > budget * (1 + slack) + (1 if slack else 0):
            found.append(f"calls in steps of {name}: {count}, the budget is {budget}")
    if same_machine:
        found += grown("bytes in steps", now["bytes"], before.get("bytes", now["bytes"]), OTHER_GROWTH)
        found += grown("at the start, sum", {k: n for k, n in now["start"].items() if k in before["start"]}, before["start"], START_GROWTH)
    if same_machine and "instructions" in now and "instructions" in before:
        a, b = before["instructions"], now["instructions"]
        if b["step"] > a["step"] * (1 + GROWTH):
            change = {f: c - a["functions"].get(f, 0) for f, c in b["functions"].items()}
            worst = sorted(change.items(), key=lambda item: -item[1])[:3]
            names = "; ".join(f"{f[:110]} +{c}" for f, c in worst if c > 0)
            found.append(f"instructions of a step: {b['step']}, the budget is {a['step']} (+{100 * (b['step'] / a['step'] - 1):.2f} %): {names}")
    return found


def examples():
    return sorted(f[:-4] for f in os.listdir(os.path.join(TREE, "scenes", "examples")) if f.endswith(".xml"))


def machines():
    """What is stored: for each machine its environment and the costs of scenes there."""
    with open(STORED, encoding="utf-8") as file:
        return json.load(file)["machines"]


def hold(stroma, update, scenes):
    here, all_machines = environment(stroma), machines()
    stored = next((m for m in all_machines if m["environment"] == here), None)
    same = stored is not None
    if update and not same:
        if scenes:
            print(f"no budgets are stored of {here}: --update without --scenes measures all of them here")
            return 1
        stored = {"environment": here, "scenes": {}}
        all_machines.append(stored)
    stored = stored or all_machines[-1]
    if not scenes:
        gone = sorted(set(stored["scenes"]) - set(examples()))
        for name in gone:
            del stored["scenes"][name]
            print(f"{name} has a budget and is no example" + ("" if update else ": --update"))
        if gone and not update:
            return 1
    if not same and not update:
        print(f"note: no budgets of {here} are stored; of {stored['environment']} calls, allocations and modules are compared")
    failed = 0
    for name in scenes or examples():
        try:
            now = measure(stroma, name)
        except RuntimeError as error:
            print(f"{name}: {error}")
            failed += 1
            continue
        if update:
            stored["scenes"][name] = now
            continue
        if name not in stored["scenes"]:
            print(f"{name}: has no budget: {sys.argv[0]} STROMA --update")
            failed += 1
            continue
        before = stored["scenes"][name]
        found = compare(now, before, same)
        for sentence in found:
            print(f"{name}: {sentence}")
        failed += bool(found)
        if "instructions" in now and "instructions" in before and same and not found:
            print(f"{name}: {now['instructions']['step']} instructions a step, budget {before['instructions']['step']}")
    if update and failed:
        print("stored.json is left as it is")
    elif update:
        with open(STORED, "w", encoding="utf-8") as file:
            json.dump({"machines": all_machines}, file, indent=1, sort_keys=True)
            file.write("\n")
    print(f"{failed} scenes cost more than their budget" if failed else "all within their budgets")
    return 1 if failed else 0


BODY = """<Node name="root" dt="0.01" gravity="0 0 -9.81">
  <Node name="body">
    <EulerImplicitSolver rayleighStiffness="0" rayleighMass="0"/>
    <CGLinearSolver iterations="1" tolerance="1e-30"/>
    <RegularGridTopology name="grid" n="NODES" min="0 0 0" max="0.2 0.2 0.2"/>
    <MechanicalObject name="dofs"/>
    <UniformMass totalMass="1"/>
    <FixedProjectiveConstraint indices="HELD"/>
    <HexahedronFEMForceField name="fem" youngModulus="1e5" poissonRatio="0.3"/>
    %s
  </Node>
  %s
</Node>
"""


def block(n):
    """A block of n nodes along each edge, held where x is least."""
    return BODY.replace("NODES", f"{n} {n} {n}").replace("HELD", " ".join(str(n * k) for k in range(n * n)))


# A part that looks at each of the 125 nodes of this one, as a box does, takes more than ASKING.
USUAL = block(5)
SMALLEST = block(3)  # for waste that takes more than the rest of the step, however large the body is


def written(folder, name, inside="", outside="", body=USUAL):
    path = os.path.join(folder, name + ".xml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(body % (inside, outside))
    return path


def self_test(stroma):
    """A component of a module outside the tree wastes: an allocation in each step, a stress that nobody reads."""
    failed = 0
    arguments = ["--module", test_module(stroma, "waste")]
    with tempfile.TemporaryDirectory() as folder:
        scene = written(folder, "lean", '<Waste name="waste" what="nothing"/>', body=SMALLEST)
        lean = {**profile(stroma, scene, arguments), "instructions": instructions(stroma, scene)}
        for what, sign in (("allocation", "observe /body/waste"), ("stress", "[Ss]train|[Ss]tress|vonMises")):
            scene = written(folder, what, f'<Waste name="waste" what="{what}"/>', body=SMALLEST)
            wasteful = {**profile(stroma, scene, arguments), "instructions": instructions(stroma, scene)}
            found = compare(wasteful, lean, True)
            print(f"{what}: {found}")
            if not any(re.search(sign, sentence) for sentence in found):
                print(f"the waste of one {what} is not found by its name")
                failed += 1
    return 1 if failed else 0


def constant(stroma):
    """A matrix that does not change is assembled and factored once."""
    body = USUAL.replace('<CGLinearSolver iterations="1" tolerance="1e-30"/>', "<SparseLDLSolver/>").replace("/>\n    %s", ' method="small"/>%s')
    again = {}
    with tempfile.TemporaryDirectory() as folder:
        for method in ("small", "polar"):
            calls = profile(stroma, written(folder, method, body=body.replace('"small"', f'"{method}"')))["calls"]
            again[method] = [name for name in calls if name.startswith(("factor ", "assemble "))]
    print(f"a constant matrix: {again['small'] or 'nothing'} is done again")
    if not again["polar"]:
        print("a matrix that changes is not made again either: the test sees nothing")
    return 0 if again["polar"] and not again["small"] else 1


def idle(stroma):
    """A step costs the same, but for what asking them takes, with parts that nobody reads, with a topology of no use, with
    components registered that no scene names, and with a damping that is written as zero."""
    others = {
        "engines that nobody reads": ('<BoxROI name="unread" box="0 0 0 1 1 1"/><BoxROI name="unread2" box="0 0 0 0.1 0.1 0.1"/>', ""),
        "a topology of no use": ("", '<Node name="unused"><RegularGridTopology n="9 9 9" min="0 0 0" max="1 1 1"/></Node>'),
        "a mapping that nobody reads": ('<Node name="unread"><MechanicalObject position="PLACES"/><BarycentricMapping/></Node>', ""),
        "an exporter at the end": ('<VTKExporter filename="out" exportAtEnd="true" exportEveryNumberOfSteps="0"/>', ""),
    }
    places = " ".join(f"{x / 100} {y / 100} {z / 100}" for x in range(5) for y in range(5) for z in range(5))
    others = {name: (inside.replace("PLACES", places), outside) for name, (inside, outside) in others.items()}
    failed = constant(stroma)
    undamped = USUAL.replace(' rayleighStiffness="0" rayleighMass="0"', "")
    with tempfile.TemporaryDirectory() as folder:
        base = instructions(stroma, written(folder, "base", body=undamped))
        runs = {name: (written(folder, f"other{k}", *parts, body=undamped), []) for k, (name, parts) in enumerate(others.items())}
        runs["a damping of zero"] = (written(folder, "damping"), [])
        runs["components that no scene names"] = (written(folder, "module", body=undamped), ["--module", test_module(stroma, "sample")])
        for name, (scene, arguments) in runs.items():
            cost = instructions(stroma, scene, arguments)
            more = cost["step"] - base["step"]
            print(f"{name}: {more:+} instructions of {base['step']}")
            failed += more > ASKING
    return 1 if failed else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stroma")
    parser.add_argument("--update", action="store_true")
    parser.add_argument("--scenes", nargs="*")
    parser.add_argument("--self-test", action="store_true")
    parser.add_argument("--idle", action="store_true")
    given = parser.parse_args()
    stroma = os.path.abspath(given.stroma)
    if given.self_test:
        return self_test(stroma)
    if given.idle:
        return idle(stroma)
    return hold(stroma, given.update, given.scenes)


if __name__ == "__main__":
    sys.exit(main())
