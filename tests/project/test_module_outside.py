#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Installs Stroma into a new folder, builds the sample module against that package and runs a scene with its force field,
by --module and by STROMA_MODULE_PATH. Usage: test_module_outside.py TREE BUILD"""
import gzip
import math
import os
import shutil
import subprocess
import sys
import tempfile

TREE, BUILD = (os.path.abspath(path) for path in sys.argv[1:3])
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(TREE, "tests", "support"))
from kept import kept  # noqa: E402


def run(*command, code=0, **options):
    result = subprocess.run(command, capture_output=True, text=True, timeout=1800, **options)
    assert result.returncode == code, f"{' '.join(command)} ended with {result.returncode}\n{result.stdout}{result.stderr}"
    return result.stdout + result.stderr


def last_positions(path):
    with gzip.open(path, "rt") as file:
        lines = [line.split("=", 1)[1] for line in file if line.strip().startswith("X=")]
    return [float(word) for word in lines[-1].split()]


def check_motion(folder):
    """A period of one second each: after it both masses are back, on opposite sides half a period before."""
    names = [name for name in os.listdir(folder) if name.endswith(".state.gz")]
    assert len(names) == 1, os.listdir(folder)
    end = last_positions(os.path.join(folder, names[0]))
    for got, expected in zip(end, (1, 0, 0, 0, 2, 0)):
        assert math.isclose(got, expected, abs_tol=0.02), end
    assert end != [1, 0, 0, 0, 2, 0], "nothing has moved"


def main():
    with tempfile.TemporaryDirectory() as folder:
        prefix, module = os.path.join(folder, "stroma"), os.path.join(folder, "module")
        with kept(os.path.join(BUILD, "install_manifest.txt")):  # of a person's own installation
            run("cmake", "--install", BUILD, "--prefix", prefix)
        stroma = os.path.join(prefix, "bin", "stroma")
        used = run("ldd", stroma)
        assert prefix + os.sep in used and BUILD + os.sep not in used, f"the installed command does not use the installed library:\n{used}"

        shutil.copytree(os.path.join(TREE, "scenes", "examples", "out_of_tree_module"), os.path.join(folder, "source"))
        run("cmake", "-S", os.path.join(folder, "source"), "-B", module, f"-DCMAKE_PREFIX_PATH={prefix}")
        run("cmake", "--build", module)
        library = os.path.join(module, "radial_springs.so")
        for name in ("radial_springs.so", "radial_springs.index", "radial_springs.manual"):
            assert os.path.exists(os.path.join(module, name)), f"{name} was not made"

        scene = os.path.join(folder, "source", "scene.xml")
        bare = dict(os.environ)
        bare.pop("STROMA_MODULE_PATH", None)
        named = dict(bare, STROMA_MODULE_PATH=module)

        message = run(stroma, "run", scene, "-n", "1", code=2, env=bare, cwd=folder)
        assert "RadialSpringForceField" in message and "scene.xml:10" in message, message
        run(stroma, "run", scene, "-n", "1000", "--record", "by_option", "--module", library, env=bare, cwd=folder)
        check_motion(os.path.join(folder, "by_option"))
        run(stroma, "run", scene, "-n", "1000", "--record", "by_path", env=named, cwd=folder)
        check_motion(os.path.join(folder, "by_path"))
        assert "RadialSpringForceField" in run(stroma, "list", "Radial", env=named, cwd=folder)
        manual = run(stroma, "doc", "RadialSpringForceField", env=named, cwd=folder)
        assert "restLength" in manual and "k/2 (r - r0)^2" in manual, manual

        # what a module lacks is told while it is built, and not in the step that would call it
        with open(os.path.join(folder, "source", "radial_spring_force_field.cpp"), "a", encoding="utf-8") as source:
            source.write('extern "C" void notThere();\nvoid callsWhatIsNotThere() { notThere(); }\n')
        built = subprocess.run(("cmake", "--build", module), capture_output=True, text=True, timeout=1800)
        assert built.returncode != 0 and "undefined symbol: notThere" in built.stdout + built.stderr, built.stdout + built.stderr
        print("installed, built outside the tree, run by --module and by STROMA_MODULE_PATH")


if __name__ == "__main__":
    main()
