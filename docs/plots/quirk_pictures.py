#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Draws what each of SOFA's quirks does to a result, for docs/tutorials/sofa.md.

  quirk_pictures.py --stroma build/release/bin/stroma --out docs/tutorials/quirks

The scenes are those of tests/sofa/test_dialect_*.py, where each way has one in which it matters. Of the number that moves most the
movement is drawn, with the way and without it; where nobody could tell them apart, their difference. Needs numpy and matplotlib,
and two minutes.
"""
import argparse
import glob
import gzip
import json
import os
import re
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
PAGE = os.path.join(ROOT, "docs", "tutorials", "sofa.md")
COLUMNS, ROWS = 5, 3  # of a picture at most
CLEAR = 0.01          # of the movement: a difference that one sees


def ways_of(page):
    """The names in the table of the page, in its order."""
    return re.findall(r"(?m)^\| `([a-z-]+)` \|", page)


def pictures_of(ways):
    """The ways of each picture, about as many in each."""
    each = -(-len(ways) // -(-len(ways) // (COLUMNS * ROWS)))
    return [ways[k:k + each] for k in range(0, len(ways), each)]


def kept_scenes(stroma, folder):
    """Way -> scenes of the test that were run without it."""
    for test in sorted(glob.glob(os.path.join(ROOT, "tests", "sofa", "test_dialect_*.py"))):
        done = subprocess.run([sys.executable, test, stroma], capture_output=True, text=True, env={**os.environ, "STROMA_TEST_SCENES": folder})
        failed = re.findall(r"(?m)^FAILED (\w+)", done.stdout)
        if done.returncode != 0 and failed != ["the_page_has_a_picture_of_each_quirk"]:  # which waits for what is drawn here
            sys.exit(done.stdout[-2000:] + done.stderr)
    found = {}
    for file in sorted(os.listdir(folder)):
        with open(os.path.join(folder, file), encoding="utf-8") as text:
            found.setdefault(file.split(".")[0], []).append(json.load(text))
    return found


def movement(stroma, given, without=None):
    """State -> times and positions, shape (instants, numbers); or nothing where the scene is refused."""
    with tempfile.TemporaryDirectory() as folder:
        for file, text in {given["name"]: given["scene"], **given["files"]}.items():
            path = os.path.join(folder, file)
            os.makedirs(os.path.dirname(path), exist_ok=True)
            with open(path, "w", encoding="utf-8") as out:
                out.write(text)
        command = [stroma, "run", given["name"], "-n", str(given["steps"]), "--quiet", "--record", "out", "--record-every", "1"]
        done = subprocess.run(command + (["--without-quirk", without] if without else []), cwd=folder, capture_output=True, text=True,
                              env={**os.environ, "STROMA_DATA_PATH": os.path.join(folder, "data")})
        states = {}
        for file in os.listdir(os.path.join(folder, "out")) if done.returncode == 0 else []:
            if file.endswith(".state.gz"):
                with gzip.open(os.path.join(folder, "out", file), "rt") as lines:
                    rows = [line.split("=")[1].split() for line in lines if line.strip().startswith(("T=", "X=", "V="))]
                states[file[:-9]] = np.array(rows[::3], float)[:, 0], np.array(rows[1::3], float)
        return states


def compared(stroma, given, way):
    """Times, what moves most with the way and without it, and by how much of the movement all differs."""
    own, other = movement(stroma, given), movement(stroma, given, way)
    best = None
    for name, (times, x) in own.items():
        shift = x - x[0]
        if name not in other:
            if shift.size and (best is None or np.abs(shift).max() > np.abs(best[1]).max()):
                best = times, shift[:, np.abs(shift).max(axis=0).argmax()], None, 0.0
            continue
        if other[name][1].shape != x.shape or not x.size:
            continue
        difference = np.abs(other[name][1] - x)
        share = difference.max() / max(np.abs(shift).max(), np.abs(other[name][1] - x[0]).max(), 1e-300)
        if best is None or share > best[3]:
            column = difference.max(axis=0).argmax()
            best = times, shift[:, column], other[name][1][:, column] - x[0, column], share
    return best


def chosen(stroma, scenes, way):
    """Of the scenes of a way the first in which one sees it."""
    found = [result for result in (compared(stroma, given, way) for given in scenes) if result]
    clear = [result for result in found if result[3] >= CLEAR]
    return clear[0] if clear else max(found, key=lambda result: result[3])


def draw(panels, file):
    figure, axes = plt.subplots(ROWS, COLUMNS, figsize=(12, 6.6), dpi=110)
    for axis in axes.flat[len(panels):]:
        axis.set_axis_off()
    for axis, (way, (times, own, other, share)) in zip(axes.flat, panels):
        if other is None:
            says = "refused without"
            axis.plot(times, own, color="#c0392b", linewidth=1.6)
        elif share < CLEAR:
            says = f"{100 * share:.2g} %, difference"
            axis.plot(times, own - other, color="#444444", linewidth=1.6)
        else:
            says = f"{100 * share:.{0 if share >= 0.1 else 1}f} %"
            axis.plot(times, own, color="#c0392b", linewidth=1.6)
            axis.plot(times, other, color="#2c6fbb", linewidth=1.6, linestyle="--")
        axis.set_title(f"{way}: {says}", fontsize=8)
        axis.tick_params(labelsize=6)
        axis.yaxis.get_offset_text().set_size(6)
        axis.ticklabel_format(axis="y", scilimits=(-2, 3))
        axis.margins(x=0)
    figure.tight_layout(pad=0.6)
    figure.savefig(file, metadata={"Software": None, "Title": " ".join(way for way, _ in panels)})
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stroma", required=True)
    parser.add_argument("--out", required=True, help="folder of the pictures; the names in each are its title")
    options = parser.parse_args()
    stroma = os.path.abspath(options.stroma)
    with open(PAGE, encoding="utf-8") as page:
        ways = ways_of(page.read())
    os.makedirs(options.out, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        scenes = kept_scenes(stroma, folder)
    missing = [way for way in ways if way not in scenes]
    if missing:
        sys.exit("no scene in tests/sofa/test_dialect_*.py leaves out " + ", ".join(missing))
    for number, some in enumerate(pictures_of(ways), 1):
        panels = [(way, chosen(stroma, scenes[way], way)) for way in some]
        for way, (_, _, other, share) in panels:
            print(way, "refused without" if other is None else f"{share:.3g}")
        draw(panels, os.path.join(options.out, f"{number}.png"))


if __name__ == "__main__":
    main()
