#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""What a picture costs beside the run that it is made of: whole processes, in turns, medians.

  picture_costs.py STROMA                 a table of all examples, and of a surface with 100,000 triangles
  picture_costs.py STROMA -n 20 --turns 5
  picture_costs.py STROMA --chromium      processor time of VTK and of headless Chromium for a picture of the same recorded states

The columns are seconds of `stroma run SCENE -n STEPS`, of `stroma picture SCENE -n STEPS`, of the same with --animate (a frame
for each of 25 instants), and the size of the picture. --chromium draws the page of `stroma view --export` by software.
"""
import argparse
import ctypes
import glob
import os
import resource
import statistics
import subprocess
import tempfile
import time

SLAB = """<Node name="root" dt="0.01"><Node name="slab"><EulerImplicitSolver/><CGLinearSolver iterations="5"/>
  <RegularGridTopology name="grid" n="159 159 2" min="0 0 0" max="1 1 0.02"/><MechanicalObject/><UniformMass totalMass="1"/>
  <HexahedronFEMForceField youngModulus="1e4" poissonRatio="0.3"/></Node></Node>"""


def seconds(stroma, folder, *arguments):
    start = time.perf_counter()
    subprocess.run([stroma, *arguments, "--quiet"], cwd=folder, check=True, capture_output=True)
    return time.perf_counter() - start


def row(stroma, folder, scene, steps, turns):
    kinds = {"run": ["run", scene, "-n", str(steps)],
             "picture": ["picture", scene, "-n", str(steps), "-o", "still.png"],
             "film": ["picture", scene, "-n", str(steps), "--animate", "--every", str(max(1, steps // 25)), "-o", "film.png"]}
    times = {name: [] for name in kinds}
    for _ in range(turns):
        for name, arguments in kinds.items():
            times[name].append(seconds(stroma, folder, *arguments))
    run, picture, film = (statistics.median(times[name]) for name in kinds)
    sizes = [os.path.getsize(os.path.join(folder, name)) / 1e3 for name in ("still.png", "film.png")]
    name = os.path.splitext(os.path.basename(scene))[0]
    print(f"| {name} | {run:.2f} | {picture:.2f} | {picture - run:+.2f} | {film:.2f} | {sizes[0]:.0f} | {sizes[1]:.0f} |", flush=True)


def processor_seconds(folder, *command):
    """Of a command and of all that it starts: this process inherits those that are left behind, and waits for them."""
    def used():
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime
    before = used()
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    try:
        while True:
            os.waitpid(-1, 0)
    except ChildProcessError:
        return used() - before


def compare_renderers(stroma, tree, steps, turns):
    become_subreaper = 36  # of prctl(2)
    ctypes.CDLL(None).prctl(become_subreaper, 1, 0, 0, 0)
    print("| scene | stroma picture [s] | Chromium [s] |\n|---|---|---|")
    for name in ("organ", "contact_tool", "cantilever"):
        with tempfile.TemporaryDirectory() as folder:
            scene = os.path.join(tree, "scenes", "examples", name + ".xml")
            subprocess.run([stroma, "run", os.path.abspath(scene), "-n", str(steps), "--record", "states", "--quiet"], cwd=folder, check=True,
                           capture_output=True)
            subprocess.run([stroma, "view", "states", "--export", "page.html", "--every", str(steps), "--quiet"], cwd=folder, check=True,
                           capture_output=True)
            vtk, browser = [], []
            for turn in range(turns):
                vtk.append(processor_seconds(folder, stroma, "picture", "states", "-o", "vtk.png", "--quiet"))
                browser.append(processor_seconds(
                    folder, "chromium", "--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
                    "--enable-unsafe-swiftshader", f"--user-data-dir={folder}/profile{turn}", "--no-first-run", "--disable-extensions",
                    "--window-size=1280,800", "--timeout=3000", f"--screenshot={folder}/browser.png", f"file://{folder}/page.html"))
                if not os.path.isfile(os.path.join(folder, "browser.png")):
                    raise SystemExit("Chromium has drawn nothing")
            print(f"| {name} | {min(vtk):.1f} | {min(browser):.1f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stroma", help="the command")
    parser.add_argument("-n", "--steps", type=int, default=25)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--chromium", action="store_true", help="compare the renderers instead")
    arguments = parser.parse_args()
    stroma = os.path.abspath(arguments.stroma)
    tree = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
    print(f"load {os.getloadavg()[0]:.1f}\n")
    if arguments.chromium:
        return compare_renderers(stroma, tree, arguments.steps, arguments.turns)
    print("| scene | run [s] | picture [s] | difference [s] | film [s] | picture [kB] | film [kB] |\n|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for scene in sorted(glob.glob(os.path.join(tree, "scenes", "examples", "*.xml"))):
            row(stroma, folder, os.path.abspath(scene), arguments.steps, arguments.turns)
        slab = os.path.join(folder, "slab_100000_triangles.xml")
        with open(slab, "w", encoding="utf-8") as file:
            file.write(SLAB)
        row(stroma, folder, slab, 1, arguments.turns)


if __name__ == "__main__":
    main()
