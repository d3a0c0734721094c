# SPDX-License-Identifier: LGPL-2.1-or-later
"""The complete liver of Marchesseau et al. 2010, section 4.3, with the parts of its material switched on one by one: how far
it swings under its weight (figure 4), and steps per second."""
import os
import subprocess
import tempfile

import numpy as np

import stroma_run as sr

SCENE = "scenes/examples/liver.xml"
SURFACE = ("meshes", "liver-smooth.obj")
SCALE, CELL, VOXEL = "0.034", "0.0115", "0.0015"  # of the surface to metres; [m]
# along the vena cava, at the back, and under the suspensory ligament, at the top
HELD = ["/liver/vein.centers=-0.06 0.13 -0.045", "/liver/vein.radii=0.03", "/liver/ligament.box=-0.03 0.15 -0.02  0.03 0.2 0.06"]
QUIET = ["/liver/paraview.enable=false"]
PARTS = {
    "hyperelastic": ["/liver/fluid.porous=false", "/liver/tissue.viscous=false"],
    "visco-hyperelastic": ["/liver/fluid.porous=false"],
    "visco-poro-hyperelastic": [],
}
ASKED = {"hyperelastic": (300, 7.5), "visco-hyperelastic": ("", 7), "visco-poro-hyperelastic": (200, 6)}
SECONDS, STEP = 6, 0.02
SPEED_STEPS, SPEED_RUNS = 300, 3


def make_mesh(stroma, folder):
    """The mesh of the surface in the shared data as settings for the scene and what the mesher said, or none."""
    surface = stroma.shared_file(*SURFACE)
    if not surface:
        return [], "The surface of a liver in the shared data is absent: the example organ stands in for it."
    path = os.path.join(folder, "liver.msh")
    result = subprocess.run([stroma.path, "mesh", surface, "-o", path, "--scale", SCALE, "--cell-size", CELL, "--voxels", VOXEL],
                            capture_output=True, text=True)
    if result.returncode:
        raise RuntimeError(result.stderr)
    said = (result.stderr.strip() + "\n" + result.stdout.strip()).replace(path, "liver.msh")
    said = "\n".join(line.split(", read ")[0] for line in said.splitlines())
    return ["/liver/loader.filename=" + path] + HELD, \
        f"`stroma mesh liver-smooth.obj -o liver.msh --scale {SCALE} --cell-size {CELL} --voxels {VOXEL}`, which says:\n\n<!-- not output -->\n```text\n{said}\n```"


def swing(stroma, settings):
    """Times [s], the largest displacement of any node from the start at each of them [m], and the size of the body [m]."""
    result = stroma.run(SCENE, settings, steps=round(SECONDS / STEP))
    if result["code"]:
        raise RuntimeError(result["message"])
    frames = result["frames"]["liver.dofs"]
    size = np.linalg.norm(frames[0].max(0) - frames[0].min(0))
    return STEP * np.arange(len(frames)), np.linalg.norm(frames - frames[0], axis=2).max(1), size


def speed(stroma, settings):
    """Steps per second: the middle of some runs, mean of a run's steps."""
    runs = []
    for _ in range(SPEED_RUNS):
        result = stroma.run(SCENE, settings, steps=SPEED_STEPS, every=SPEED_STEPS)
        if result["code"]:
            raise RuntimeError(result["message"])
        runs.append(result["summary"]["ms_per_step"]["mean"])
    return 1000 / sorted(runs)[SPEED_RUNS // 2]


def run(stroma, out, report):
    with tempfile.TemporaryDirectory() as folder:
        mesh, source = make_mesh(stroma, folder)
        curves, rows = {}, []
        for name, off in PARTS.items():
            settings = QUIET + mesh + off
            times, largest, size = swing(stroma, settings)
            few = swing(stroma, settings + ["/liver/linear.iterations=25"])[1]
            curves[name] = (times, largest)
            rest = largest[-1]
            asked, paper = ASKED[name]
            apart = np.abs(few - largest).max() / size
            rows.append([name, f"{1e3 * largest.max():.1f} at {times[largest.argmax()]:.2f} s", f"{1e3 * rest:.1f}",
                         f"{largest.max() / rest - 1:.2f}", f"{100 * apart:.2f} %",
                         f"{speed(stroma, settings + ['/liver/linear.iterations=25']):.0f}", asked, paper])
            print("  ", name, flush=True)
    sr.write_csv(os.path.join(out, "complete_liver.csv"), ["t [s]"] + [f"{name} [m]" for name in curves],
                 np.column_stack([times, *(c[1] for c in curves.values())]))
    draw(os.path.join(out, "complete_liver.png"), curves)
    largest = {name: float(row[1].split()[0]) for name, row in zip(PARTS, rows)}
    order = sorted(largest, key=largest.get)
    report.append(f"""## The complete liver (Marchesseau et al. 2010, section 4.3)

{source}

`{SCENE}` with this mesh, held where a vena cava would run and at the top, and let go under its weight: Arruda-Boyce tissue,
with a viscosity, and with fluid in its pores. The table has how far any node gets from where it was in the first {SECONDS} s
(largest, and at their end), and how far the largest swings beyond the end. Then it has how far 25 iterations of conjugate gradients
per step, as in the paper, are from the scene's own limit of 300, as a share of the body's size. Steps per second are on one thread
with 25 iterations.

""" + sr.markdown(["material", "largest [mm]", f"after {SECONDS} s [mm]", "swings beyond by", "25 iterations are off by",
                   "steps per second", "asked", "the paper"], rows) + f"""
From the smallest amplitude to the largest: {', '.join(order)}. The paper has hyperelastic, visco-poro-hyperelastic,
visco-hyperelastic (its figure 4 prints no numbers).

![amplitudes](complete_liver.png)
""")


def draw(path, curves):
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(figsize=(7, 4), constrained_layout=True)
    for name, (times, largest) in curves.items():
        axes.plot(times, 1e3 * largest, label=name)
    axes.set(xlabel="t [s]", ylabel="largest displacement [mm]", title="A liver let go under its weight")
    axes.legend()
    figure.savefig(path, dpi=90)
    plt.close(figure)
