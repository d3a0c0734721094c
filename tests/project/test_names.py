#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""A test has the same name in every run: what its parameter is called, and no address or bytes of it. The costs by which ctest begins
are of tests that exist."""
import glob
import os
import re
import subprocess
import sys

names = []
for program in sorted(glob.glob(os.path.join(sys.argv[1], "bin", "test_*"))):
    listed = subprocess.run([program, "--gtest_list_tests"], capture_output=True, text=True, check=True).stdout.splitlines()
    names += [f"{os.path.basename(program)} {line.strip()}" for line in listed if line.startswith("  ")]
assert len(names) > 1000, names
wrong = [name[:160] for name in names if re.search(r"-byte object <|\b0x[0-9a-f]+", name)]
assert not wrong, f"{len(wrong)} of {len(names)} names are others in the next run: {wrong[:5]}: give their parameters an operator<<"
with open(os.path.join(os.path.dirname(__file__), "..", "costs", "costs.cmake"), encoding="utf-8") as file:
    costs = re.findall(r"\b\d+:([^\s)]+)", file.read())
listed = subprocess.run(["ctest", "--test-dir", sys.argv[1], "-N"], capture_output=True, text=True, check=True).stdout
tests = set(re.findall(r"Test +#\d+: (\S+)", listed))
assert costs and not set(costs) - tests, f"no such tests: {sorted(set(costs) - tests)[:5]} (tests/costs/costs.cmake)"
print(f"{len(names)} tests have names that stay, {len(costs)} have costs")
