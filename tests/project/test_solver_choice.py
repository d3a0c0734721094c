#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""docs/scale.md must have the table that tools/bench/solver_choice.py prints from the stored measurements, and every stored row must
be of a scene that exists."""
import os
import subprocess
import sys


def main():
    root = sys.argv[1]
    tool, stored = os.path.join(root, "tools", "bench", "solver_choice.py"), os.path.join(root, "docs", "experiments", "solver_choice.csv")
    done = subprocess.run([sys.executable, tool, "--table", stored], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    printed = done.stdout.strip().split("\n")
    assert len(printed) > 5, done.stdout
    with open(os.path.join(root, "docs", "scale.md")) as file:
        page = file.read()
    for line in printed:
        assert line in page, f"docs/scale.md does not have the line that {tool} --table prints: {line}"
    sys.path.insert(0, os.path.dirname(tool))
    sys.dont_write_bytecode = True
    import solver_choice
    import solver_scenes
    known = {(scene.set, scene.name): scene for scene in solver_scenes.scenes()}
    for row in solver_choice.read(stored):
        scene = known[row["set"], row["scene"]]
        assert float(row["within"]) == float(f"{solver_choice.within(scene):.1e}"), row["scene"]


main()
