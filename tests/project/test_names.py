#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""A test has the same name in every run: what its parameter is called, and no address or bytes of it."""
import re
import subprocess
import sys

names = subprocess.run(["ctest", "--test-dir", sys.argv[1], "-N"], capture_output=True, text=True, check=True).stdout.splitlines()
names = [line.split(": ", 1)[1] for line in names if re.match(r" +Test +#", line)]
assert len(names) > 1000, names
wrong = [name[:160] for name in names if re.search(r"-byte object <|\b0x[0-9a-f]+", name)]
assert not wrong, f"{len(wrong)} of {len(names)} names are others in the next run: {wrong[:5]}: give their parameters an operator<<"
print(f"{len(names)} tests have names that stay")
