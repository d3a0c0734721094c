#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Dynamic mechanical analysis of Marchesseau et al. 2010, section 4.2: a disc between two plates, the upper one swinging.

  docs/validate/dma.py --stroma build/release/bin/stroma --out docs/experiments
  docs/validate/dma.py --mesh scenes/meshes/disc.msh 8 4

Runs scenes/validation/dma.xml over frequencies and meshes, takes the complex modulus from the torque on the upper plate,
G* = 2 H T/(pi R^4 angle), and compares it with the two-mode generalised Maxwell model whose parameters the scene has. Writes
OUT/dma.md, dma.csv and dma.png. --mesh writes a disc of n x n x m cells, each cut into six tetrahedra, and nothing else.
"""
import argparse
import os
import subprocess
import sys
import tempfile

import numpy as np

import stroma_run as sr

RADIUS, HEIGHT, ANGLE = 0.01, 0.004, 0.004  # [m], [m], [rad]: strains of 1 % at the rim
G0, ALPHA, TAU = 770.0, np.array([0.235, 0.333]), np.array([0.27, 0.03])
FREQUENCIES = np.array([0.3, 1, 3, 10, 30, 100])  # [rad/s]
# cells across and in height, update, steps per period, frequencies (the fine mesh takes half a second per step on a busy machine)
MESHES = [(8, 4, "backward", 40, 6), (10, 5, "backward", 40, 6), (10, 5, "exponential", 40, 6), (24, 10, "exponential", 40, 6)]
CUT = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]


def disc(n, m):
    """Nodes and tetrahedra of a disc: a square of n x n cells whose rings become circles, in m layers."""
    s = np.linspace(-1, 1, n + 1)
    nodes = []
    for z in np.linspace(0, HEIGHT, m + 1):
        for v in s:
            for u in s:
                # squares become circles of the same number, evenly filled (Shirley and Chiu 1997)
                if abs(u) > abs(v):
                    r, a = u, np.pi / 4 * v / u
                else:
                    r, a = (v, np.pi / 2 - np.pi / 4 * u / v) if v else (0, 0)
                nodes.append((RADIUS * r * np.cos(a), RADIUS * r * np.sin(a), z))
    nodes = np.array(nodes)
    cells = []
    for k in range(m):
        for j in range(n):
            for i in range(n):
                at = (k * (n + 1) + j) * (n + 1) + i
                row, layer = n + 1, (n + 1) ** 2
                c = [at, at + 1, at + row + 1, at + row]
                c += [x + layer for x in c]
                cells += [[c[q] for q in t] for t in CUT]
    return nodes, np.array(cells)


def write_msh(path, nodes, cells):
    with open(path, "w") as file:
        file.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n" % len(nodes))
        for i, p in enumerate(nodes):
            file.write("%d %.10g %.10g %.10g\n" % (i + 1, *p))
        file.write("$EndNodes\n$Elements\n%d\n" % len(cells))
        for i, c in enumerate(cells):
            file.write("%d 4 2 0 1 %d %d %d %d\n" % (i + 1, *(c + 1)))
        file.write("$EndElements\n")


def closed_form(w):
    return G0 * (1 - ALPHA.sum() + (ALPHA * 1j * w * TAU / (1 + 1j * w * TAU)).sum())


def measure(stroma, mesh, nodes, update, steps, w):
    """The complex modulus [Pa] from the last of the periods that let transients decay."""
    period = 2 * np.pi / w
    periods = 2 + int(8 * TAU.max() / period)
    top = np.flatnonzero(np.abs(nodes[:, 2] - HEIGHT) < 1e-9)
    with tempfile.TemporaryDirectory() as folder:
        name = os.path.join(folder, "torque")
        settings = {"/.dt": period / steps, "/disc/loader.filename": mesh, "/disc/plate.pulsation": w,
                    "/disc/law.viscousUpdate": update, "/disc/torque.fileName": name}
        command = [stroma, "run", os.path.join(sr.ROOT, "scenes/validation/dma.xml"), "--quiet", "--no-record", "-n",
                   str(steps * periods)]
        for key, value in settings.items():
            command += ["--set", f"{key}={value if isinstance(value, str) else repr(float(value))}"]
        result = subprocess.run(command, capture_output=True, text=True)
        if result.returncode:
            sys.exit(result.stderr)
        rows = np.loadtxt(name + "_f.txt", comments="#")[-steps:]
    force = rows[:, 1:].reshape(len(rows), -1, 3)
    torque = -(nodes[top, 0] * force[:, :, 1] - nodes[top, 1] * force[:, :, 0]).sum(axis=1)
    amplitude = 2j / steps * (torque * np.exp(-1j * w * rows[:, 0])).sum()  # of T = Im(amplitude exp(i w t))
    return amplitude * 2 * HEIGHT / (np.pi * RADIUS ** 4 * ANGLE)


def run(stroma, out):
    rows, columns = [], []
    with tempfile.TemporaryDirectory() as folder:
        for n, m, update, steps, count in MESHES:
            nodes, cells = disc(n, m)
            mesh = os.path.join(folder, f"disc_{n}_{m}.msh")
            write_msh(mesh, nodes, cells)
            columns.append(f"{len(cells)} tets, {update}, {steps} steps per period")
            found = [measure(stroma, mesh, nodes, update, steps, w) for w in FREQUENCIES[:count]]
            rows.append(np.array(found + [np.nan] * (len(FREQUENCIES) - count)))
            errors = np.abs(rows[-1] / [closed_form(w) for w in FREQUENCIES] - 1)
            print(columns[-1], "mean error %.2f %%, largest %.2f %%" % (100 * np.nanmean(errors), 100 * np.nanmax(errors)),
                  flush=True)
    exact = np.array([closed_form(w) for w in FREQUENCIES])
    header = ["w [1/s]", "closed form: size, G', G'' [Pa]"] + columns
    table = [[f"{w:g}", f"{abs(g):.1f} {g.real:.1f} {g.imag:.1f}"] +
             ["" if np.isnan(r[i]) else f"{abs(r[i]):.1f} {r[i].real:.1f} {r[i].imag:.1f} ({100 * abs(r[i] / g - 1):.2f} %)"
              for r in rows]
             for i, (w, g) in enumerate(zip(FREQUENCIES, exact))]
    mean = ["mean", ""] + [f"{100 * np.nanmean(np.abs(r / exact - 1)):.2f} %" for r in rows]
    sr.write_csv(os.path.join(out, "dma.csv"), ["w", "closed_storage", "closed_loss"] +
                 [f"{part} {c}" for c in columns for part in ("storage", "loss")],
                 [[w, g.real, g.imag] + [v for r in rows for v in (r[i].real, r[i].imag)]
                  for i, (w, g) in enumerate(zip(FREQUENCIES, exact))])
    with open(os.path.join(out, "dma.md"), "w") as file:
        file.write(f"""# Dynamic mechanical analysis of a disc (Marchesseau et al. 2010, section 4.2)

Written by `docs/validate/dma.py`; {sr.machine()}.

A disc of radius {RADIUS * 1e3:g} mm and height {HEIGHT * 1e3:g} mm between plates, the upper one swinging by {ANGLE:g} rad
(`scenes/validation/dma.xml`, St Venant-Kirchhoff, without inertia). G* is taken from the torque on the upper plate over the last
period. The closed form is the generalised Maxwell model with G_0 = 770 Pa, shares 0.235 and 0.333, times 0.27 s and 0.03 s. The
errors are |G*/G*_closed - 1|. The paper's simulation was within 5 % of its measurements, in the mean.

""" + sr.markdown(header, table + [mean]))
    draw(os.path.join(out, "dma.png"), columns, rows)


def draw(path, columns, rows):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    w = np.geomspace(0.2, 150, 200)
    g = np.array([closed_form(x) for x in w])
    plt.figure(figsize=(6, 4))
    plt.loglog(w, g.real, "k-", label="G' closed form")
    plt.loglog(w, g.imag, "k--", label="G'' closed form")
    for marker, column, row in zip("ox+s", columns, rows):
        plt.loglog(FREQUENCIES, row.real, marker, mfc="none", label=column)
        plt.loglog(FREQUENCIES, row.imag, marker, mfc="none", color=plt.gca().lines[-1].get_color())
    plt.xlabel("w [1/s]")
    plt.ylabel("[Pa]")
    plt.legend(fontsize=7)
    plt.tight_layout()
    plt.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stroma", help="the stroma command")
    parser.add_argument("--out", help="folder for the table and the figure")
    parser.add_argument("--mesh", nargs=3, metavar=("FILE", "N", "M"), help="write a mesh and stop")
    arguments = parser.parse_args()
    if arguments.mesh:
        return write_msh(arguments.mesh[0], *disc(int(arguments.mesh[1]), int(arguments.mesh[2])))
    if not arguments.stroma or not os.access(arguments.stroma, os.X_OK) or not arguments.out:
        sys.exit("expected --stroma, the stroma command, and --out, a folder")
    os.makedirs(arguments.out, exist_ok=True)
    run(os.path.abspath(arguments.stroma), arguments.out)


if __name__ == "__main__":
    main()
