#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Measures the time from a changed file to the result of its tests: wall time of the build, and of the tests, for one change of each kind.

The build must be up to date. No compiler cache answers: each file is compiled again, though only its time stamp changes.
Run it on an otherwise idle machine.

Usage: tools/change_times.py BUILD"""
import os
import subprocess
import sys
import time

CHANGES = (  # what changes, the file, the target to build, the tests
    ("a law", "components/hyperelasticity/yeoh.cpp", "stroma_hyperelasticity", r"^hyperelasticity\.HyperelasticMaterials$"),
    ("an attribute of a linear solver", "components/iterative_solvers/cg_linear_solver.cpp", "stroma_iterative_solvers",
     r"^iterative_solvers\.CGLinearSolver$"),
    ("an integrator", "components/integrators/euler_implicit_solver.cpp", "stroma_integrators", r"^integrators\.Orders$"),
    ("contact by constraints", "components/contact/constraint_contact.cpp", "stroma_contact", r"^contact\.ConstraintContact$"),
    ("a header of a family", "components/iterative_solvers/krylov_solver.h", "stroma_iterative_solvers",
     r"^iterative_solvers\.CGLinearSolver$"),
    ("a test", "tests/hyperelasticity/test_ogden.cpp", "bin/test_hyperelasticity", r"^hyperelasticity\.Ogden$"),
    ("how scenes are read", "tools/xml_text/overrides.cpp", "bin/test_scene", r"^scene\."),
    ("the page of the view", "tools/view/page/src/legend.js", "all", r"^view\.parts_of_the_page$"),
)


def seconds_of(command, environment):
    begin = time.monotonic()
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"change_times.py: {' '.join(command)} failed:\n{done.stdout[-3000:]}{done.stderr[-3000:]}")
    return time.monotonic() - begin


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: tools/change_times.py BUILD")
    build = sys.argv[1]
    root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    environment = dict(os.environ, CCACHE_DISABLE="1")
    print(f"{'change':34} {'build':>8} {'tests':>8}")
    for what, file, target, tests in CHANGES:
        seconds_of(["ninja", "-C", build, "-j2"], environment)
        os.utime(os.path.join(root, file))
        built = seconds_of(["ninja", "-C", build, "-j2", target], environment)
        tested = seconds_of(["ctest", "--test-dir", build, "-j2", "--no-tests=error", "-R", tests], environment)
        print(f"{what:34} {built:6.1f} s {tested:6.1f} s", flush=True)


if __name__ == "__main__":
    main()
