# SPDX-License-Identifier: LGPL-2.1-or-later
"""Each of folder_scenes.py runs ten steps, and so does its migrated scene with the same bits, or is refused in one message that
names all that is missing: no crash, no hang. Usage: test_folder_scenes.py STROMA [WORD [-v]]; -v prints what each one says."""
import concurrent.futures
import gzip
import math
import os
import subprocess
import sys
import tempfile

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from folder_scenes import FILES, MISSING, SCENES
from started import Started

STROMA = Started(sys.argv[1])
STEPS = 10


def stroma(folder, *words):
    done = STROMA.run(words, folder)
    return done.returncode, done.stdout + done.stderr


def states_in(folder):
    """The recorded states of a run, as text."""
    states = {}
    for file in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
        if file.endswith(".state.gz"):
            with gzip.open(os.path.join(folder, file), "rt") as lines:
                states[file] = lines.read()
    return states


def problem_of(name):
    """What is wrong with a scene, or None; and what it said."""
    with tempfile.TemporaryDirectory() as folder:
        for file, text in {**FILES, "scene.scn": SCENES[name]}.items():
            os.makedirs(os.path.dirname(os.path.join(folder, file)) or folder, exist_ok=True)
            with open(os.path.join(folder, file), "w") as out:
                out.write(text)
        os.makedirs(os.path.join(folder, "out"))
        code, said = stroma(folder, "run", "scene.scn", "-n", str(STEPS), "--record", "first")
        missing = MISSING.get(name)
        if missing:
            wrong = code != 2 or any(word not in said for word in missing)
            return ("is not refused for " + ", ".join(missing) if wrong else None), said
        if code != 0:
            return f"ends with {code}", said
        states = states_in(os.path.join(folder, "first"))
        if not states:
            return "records nothing", said
        for text in states.values():
            numbers = [float(word) for line in text.splitlines() if "X=" in line for word in line.split("=")[1].split()]
            if not numbers or not all(math.isfinite(number) for number in numbers):
                return "has no finite positions", said
        code, native = stroma(folder, "migrate", "scene.scn", "-o", "native.xml")
        if code != 0:
            return f"is not migrated ({code})", native
        code, native = stroma(folder, "run", "native.xml", "-n", str(STEPS), "--record", "second")
        if code != 0:
            return f"ends with {code} when migrated", native
        return (None if states_in(os.path.join(folder, "second")) == states else "has other numbers when migrated"), said


def tried(name):
    try:
        return name, *problem_of(name)
    except subprocess.TimeoutExpired:
        return name, "hangs", ""


def main():
    word = sys.argv[2] if len(sys.argv) > 2 else ""
    chosen = [name for name in SCENES if word in name]
    unknown = sorted(set(MISSING) - set(SCENES))
    failed = len(unknown)
    for name in unknown:
        print("FAILED", name, "is no scene")
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for name, problem, said in pool.map(tried, chosen):
            if problem:
                failed += 1
                print("FAILED", name, problem, flush=True)
                print("   ", said.strip().replace("\n", "\n    "), flush=True)
            elif "-v" in sys.argv:
                print("ok    ", name, "(refused)" if name in MISSING else "")
                print("   ", said.strip().replace("\n", "\n    "), flush=True)
    print(f"{len(chosen) - failed} of {len(chosen)} scenes, {len(MISSING)} of them refused")
    sys.exit(1 if failed or not chosen else 0)


main()
