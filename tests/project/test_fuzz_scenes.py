#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""tests/fuzz/fuzz_scenes.py finds what a program may do wrong, here one that does it on purpose; and a short run of it with the
real one finds nothing. Usage: test_fuzz_scenes.py TREE STROMA"""
import os
import re
import subprocess
import sys
import tempfile

TREE, STROMA = sys.argv[1:3]
SCRIPT = os.path.join(TREE, "tests", "fuzz", "fuzz_scenes.py")
WRONG = {  # what the program does: part of the expected finding
    "kill -SEGV $$": "crash: code -11",
    "exit 1": "crash: code 1",
    "exec sleep 100000": "hang: no end within",
    "exit 2": "silent: code 2",
    "exec head -c 300000000 /dev/zero | tail | wc -c; exit 0": "memory: ",
    "mkdir -p out; printf 'T= 0\\n  X= 0 nan 1\\n' > out/a.state; exit 0": "not finite: out/a.state",
    "mkdir -p out; printf 'T= 0\\n  X= 0 -inf 1\\n' | gzip > out/a.state.gz; exit 0": "not finite: out/a.state.gz",
    "mkdir -p out; printf 'T= 0\\n  X= 0 1e3 1\\n' > out/information.nan; exit 0": None,
}


def run(stroma, *options):
    return subprocess.run([sys.executable, SCRIPT, "--stroma", stroma, "--seed", "3", *options], capture_output=True, text=True)


def main():
    with tempfile.TemporaryDirectory() as folder:
        program = os.path.join(folder, "program")
        for what, finding in WRONG.items():
            with open(program, "w", encoding="utf-8") as file:
                file.write(f"#!/bin/sh\n[ $1 = check ] && exit 0\n{what}\n")
            os.chmod(program, 0o755)
            seconds = "1" if "sleep" in what else "1800"  # only what never ends is judged by the clock
            said = run(program, "--count", "1", "--seconds", seconds, "--memory", "200")
            assert (finding or "0 with problems") in said.stdout, f"{what}: expected {finding} in:\n{said.stdout}{said.stderr}"
            assert said.returncode == (1 if finding else 0), f"{what}: {said}"
    said = run(STROMA, "--count", "100", "--jobs", "2", "--seconds", "1800")
    print(said.stdout + said.stderr)
    assert said.returncode == 0, "a damaged scene does harm"
    ran = re.search(r"(\d+) ran, (\d+) refused", said.stdout)
    assert ran and int(ran.group(1)) > 10 and int(ran.group(2)) > 10, "most mutants end in the same way"


if __name__ == "__main__":
    main()
