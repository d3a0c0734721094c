#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The modules that `tools/setup run` builds are those that its scene opens. Usage: test_first_scene.py TREE STROMA MODULE..."""
import os
import subprocess
import sys

TREE, STROMA, BUILT = sys.argv[1], sys.argv[2], set(sys.argv[3:])


def main():
    with open(os.path.join(TREE, "tools", "setup"), encoding="utf-8") as file:
        assert "scenes/examples/organ.xml" in file.read(), "another scene is the first one now"
    scene = os.path.join(TREE, "scenes", "examples", "organ.xml")
    said = subprocess.run([STROMA, "explain", scene], capture_output=True, text=True, check=True, timeout=600).stdout
    line = next(line for line in said.split("\n") if line.startswith("modules opened: "))
    opened = set(line.split(": ", 1)[1].split(" (")[0].split(", "))
    assert opened == BUILT, f"opened {sorted(opened)}, built first {sorted(BUILT)}"
    print(f"the first scene opens {len(opened)} modules, and those are built first")


if __name__ == "__main__":
    main()
