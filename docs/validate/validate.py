#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs the experiments of Nesme et al. 2005 and hyperelastic benchmarks, and writes their tables and figures.

  docs/validate/validate.py --stroma build/release/bin/stroma --out docs/experiments
  docs/validate/validate.py --stroma ... --out ... --only torque beam

Fixed beam (figures 8 and 9), time per step (figures 4 and 7), artificial torque (figure 3), dragged liver (figures 5 and 6),
truth cube (tables 1 to 3); deforming bar of Land et al. 2015 and an inflated sphere; the complete liver of Marchesseau et al.
2010. The measured beads of the truth cube and the livers are read from --data: without them the truth cube is skipped and the
example organ stands in for a liver, and the text says so.
Writes a page for each experiment, CSV and most a picture, and OUT/README.md, which lists all pages of the folder. The truth
cube takes about seven minutes on a quiet machine, the rest three. Needs numpy and matplotlib. docs/validate/condensation.py,
condensed_mass.py, dma.py, scale.py, statics.py and stability.py are programs of their own; `stroma bench --accuracy` prints accuracy.md.
"""
import argparse
import datetime
import os
import sys

import matplotlib

matplotlib.use("Agg")

import beam  # noqa: E402
import complete_liver  # noqa: E402
import cost  # noqa: E402
import drag  # noqa: E402
import hyperelastic  # noqa: E402
import robustness  # noqa: E402
import stroma_run as sr  # noqa: E402
import truth_cube  # noqa: E402

EXPERIMENTS = {"beam": beam.run, "cost": cost.run, "torque": robustness.run, "liver": drag.run,
               "truth_cube": truth_cube.run, "hyperelastic": hyperelastic.run, "complete_liver": complete_liver.run}
PAGES = [*EXPERIMENTS, "visco_poro", "dma", "condensation", "statics", "accuracy"]  # the last five are not written here


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stroma", required=True, help="the stroma command")
    parser.add_argument("--out", required=True, help="folder for the tables and figures")
    parser.add_argument("--only", nargs="+", choices=EXPERIMENTS, help="experiments to run; all when not given")
    parser.add_argument("--data", metavar="FOLDER",
                        help="real measurements and meshes; the environment variable STROMA_SHARED_DATA, or the shared data "
                        "beside the checkout when not given")
    arguments = parser.parse_args()
    if not os.access(arguments.stroma, os.X_OK):
        sys.exit(f"{arguments.stroma} is not a program: expected the stroma command, as build/release/bin/stroma")
    if arguments.data and not os.path.isdir(arguments.data):
        sys.exit(f"{arguments.data} is not a folder: expected that of the real measurements and meshes")
    os.makedirs(arguments.out, exist_ok=True)
    stroma = sr.Stroma(arguments.stroma, arguments.data or sr.default_data())
    for name in arguments.only or EXPERIMENTS:
        print(name, flush=True)
        report = []
        EXPERIMENTS[name](stroma, arguments.out, report)
        write_page(os.path.join(arguments.out, name + ".md"), report)
    write_index(arguments.out)
    print(os.path.join(arguments.out, "README.md"), "written")


def write_page(path, report):
    with open(path, "w") as file:
        file.write(f"Written by `docs/validate/validate.py` on {datetime.date.today()}; {sr.machine()}.\n\n" + "\n".join(report))


def write_index(folder):
    """The list of the pages that are there: those of earlier runs keep their date."""
    lines = ["# Experiments\n"]
    for name in PAGES:
        path = os.path.join(folder, name + ".md")
        if os.path.exists(path):
            with open(path) as file:
                title = next((line.strip("# \n") for line in file if line.startswith("# ") or line.startswith("## ")), name)
            lines.append(f"- [{title}]({name}.md)")
    with open(os.path.join(folder, "README.md"), "w") as file:
        file.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
