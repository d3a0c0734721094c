#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Draws the benchmarks of docs/contact.md.

  contact_pictures.py --bin build/release/bin --out docs/contact
  contact_pictures.py --bin ... --out ... --only arch ironing

The scenes are those of the tests: a test program keeps them where STROMA_TEST_SCENES says, and `stroma picture` runs and draws
them. Needs some minutes of a processor.
"""
import argparse
import os
import subprocess
import sys
import tempfile

# name of the picture: test, which of its scenes, options of `stroma picture`
PICTURES = {
    "hertz": ("ClosedForms.HertzsSphereOnALayer", -1, "-n 1 --field vonMises --edges --view front --bare"),
    "ironing": ("PublishedBenchmarks.ShallowIroningPressed", 0, "-n 13 --field vonMises --edges --view front --bare"),
    "spheres": ("PublishedBenchmarks.HollowSpheresBetweenPlates", 0, "-n 24 --field vonMises --edges --view front --bare --size 640x360"),
    "arch_stands": ("Arch.StandsWhereItIsThickEnough", 0, "-n 60 --field displacement --view front"),
    "arch_falls": ("Arch.StandsWhereItIsThickEnough", 1, "-n 60 --field displacement --view front"),
}


def scenes_of(test, program, folder):
    """Files of the scenes of a test, in the order in which it made them."""
    os.makedirs(folder, exist_ok=True)
    result = subprocess.run([program, f"--gtest_filter={test}"], capture_output=True, text=True,
                            env={**os.environ, "STROMA_TEST_SCENES": folder})
    if result.returncode != 0:
        sys.exit(result.stdout + result.stderr)
    for name in os.listdir(folder):  # a picture has up where gravity says; some of these scenes have none
        path = os.path.join(folder, name)
        with open(path, encoding="utf-8") as file:
            text = file.read()
        with open(path, "w", encoding="utf-8") as file:
            file.write(text.replace('gravity="0 0 0"', 'gravity="0 0 -1e-6"'))
    return sorted((os.path.join(folder, name) for name in os.listdir(folder)), key=lambda path: int(path.split(".")[-2]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", required=True, help="folder of stroma and of the test programs")
    parser.add_argument("--out", required=True, help="folder for the pictures")
    parser.add_argument("--only", nargs="+", choices=PICTURES, default=list(PICTURES))
    options = parser.parse_args()
    os.makedirs(options.out, exist_ok=True)
    made = {}
    with tempfile.TemporaryDirectory() as place:
        for name in options.only:
            test, which, settings = PICTURES[name]
            if test not in made:
                made[test] = scenes_of(test, os.path.join(options.bin, "test_contact"), os.path.join(place, test))
            file = os.path.join(options.out, name + ".png")
            command = [os.path.join(options.bin, "stroma"), "picture", made[test][which], "-o", file, "--quiet", *settings.split()]
            subprocess.run(command, check=True)
            print(file)


if __name__ == "__main__":
    main()
