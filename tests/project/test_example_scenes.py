#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Every example scene passes `stroma check` without a warning, runs, says in its comment how to run it, and is in the list
of the regression tests. Usage: test_example_scenes.py TREE STROMA"""
import glob
import os
import re
import subprocess
import sys
import tempfile

# The liver's fluid has not left its first cells before, which is told.
STEPS = {"liver.xml": "5"}
TREE, STROMA = (os.path.abspath(path) for path in sys.argv[1:3])


def main():
    scenes = sorted(glob.glob(os.path.join(TREE, "scenes", "examples", "*.xml")))
    with open(os.path.join(TREE, "scenes", "regression", "list"), encoding="utf-8") as file:
        listed = {os.path.basename(line.split()[0]) for line in file if line.strip() and not line.startswith("#")}
    problems = []
    for scene in scenes:
        name = os.path.basename(scene)
        with open(scene, encoding="utf-8") as file:
            text = file.read()
        command = re.search(r"stroma run (\S+) -n (\d+)", text)
        if not command or command.group(1) != f"scenes/examples/{name}":
            problems.append(f"{name}: its comment does not say how to run it")
        if name not in listed:
            problems.append(f"{name}: is not in scenes/regression/list")
        with tempfile.TemporaryDirectory() as folder:
            for arguments in (["check", scene], ["run", scene, "-n", STEPS.get(name, "2"), "--quiet"]):
                result = subprocess.run([STROMA, *arguments], capture_output=True, text=True, cwd=folder, timeout=600)
                if result.returncode != 0 or "warning" in result.stderr + result.stdout:
                    problems.append(f"{name}: stroma {arguments[0]} ended with {result.returncode}\n"
                                    f"{result.stdout}{result.stderr}")
    for problem in problems:
        print(problem)
    print(f"{len(scenes)} example scenes, {len(problems)} problems")
    sys.exit(1 if problems or len(scenes) < 10 else 0)


if __name__ == "__main__":
    main()
