#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Draws the benchmarks of docs/contact.md.

  contact_pictures.py --bin build/release/bin --out docs/contact
  contact_pictures.py --bin ... --out ... --only arch ironing

The scenes are those of the tests: a test program keeps them where STROMA_TEST_SCENES says, and `stroma picture` runs and draws
them. Where held nodes would cover everything, the bodies are drawn bare, and the legend is taken from a picture with one. Needs Pillow
and some minutes of a processor.
"""
import argparse
import os
import subprocess
import sys
import tempfile

from PIL import Image, ImageChops

# name of the picture: test, which of its scenes, options of `stroma picture`, whether bodies are drawn bare and what is kept of them
PICTURES = {
    "hertz": ("ClosedForms.HertzsSphereOnALayer", -1, "-n 1 --field vonMises --edges --view front --size 4000x3600",
              (1560, 1960, 2460, 2600)),
    "ironing": ("PublishedBenchmarks.ShallowIroningPressed", 0, "-n 13 --field vonMises --edges --view front", "bare"),
    "spheres": ("PublishedBenchmarks.HollowSpheresBetweenPlates", 0, "-n 24 --field vonMises --edges --view front --size 960x540", "bare"),
    "punch": ("ClosedForms.FlatPunch", 1, "-n 1 --field vonMises --edges --view front --size 4000x3600", (360, 160, 1360, 1010)),
    "cone": ("ClosedForms.Cone", 0, "-n 1 --field vonMises --edges --view front --size 4000x3600", (240, 160, 1090, 860)),
    "patch": ("FlatFaces.PatchOfTwoBlocks", 5, "-n 1 --field vonMises --edges", "bare"),
    "twist": ("PublishedBenchmarks.HemisphereTwisted", 1, "-n 20 --field vonMises --edges --view 25,25", "bare"),
    "arch_stands": ("Arch.StandsWhereItIsThickEnough", 0, "-n 60 --field displacement --view front", None),
    "arch_falls": ("Arch.StandsWhereItIsThickEnough", 1, "-n 60 --field displacement --view front", None),
}
MARGIN, LEGEND_HEIGHT = 30, 600  # pixels; of the picture that the legend is taken from


def trimmed(image):
    """Without white around it."""
    return image.crop(ImageChops.difference(image, Image.new("RGB", image.size, "white")).getbbox())


def legend_of(file, height):
    """The last group of columns that have something, from a picture of 1200 x `height`."""
    with Image.open(file) as opened:
        image = opened.convert("RGB")
    used = ImageChops.difference(image, Image.new("RGB", image.size, "white")).convert("L").resize((image.width, 1), Image.BOX)
    empty, last = 0, 0
    for column in reversed(range(image.width)):
        is_empty = used.getpixel((column, 0)) == 0
        last = last or (0 if is_empty else column)
        empty = empty + 1 if is_empty else 0
        if last and empty > 40:
            return trimmed(image.crop((column, 0, image.width, height)))
    sys.exit(f"{file} has no legend")


def draw(stroma, scene, settings, bare, file):
    """Bodies, and beside them the legend."""
    command = [stroma, "picture", scene, "--quiet", *settings.split()]
    without_size = command[:command.index("--size")] if "--size" in command else command
    if not bare:
        subprocess.run([*command, "-o", file], check=True)
        return
    subprocess.run([*command, "--bare", "-o", file], check=True)
    with Image.open(file) as opened:
        bodies = opened.convert("RGB")
    bodies = trimmed(bodies) if bare == "bare" else bodies.crop(bare)
    subprocess.run([*without_size, "--size", f"1200x{LEGEND_HEIGHT}", "-o", file], check=True)
    legend = legend_of(file, LEGEND_HEIGHT)
    height = max(bodies.height, legend.height) + 2 * MARGIN
    whole = Image.new("RGB", (bodies.width + legend.width + 3 * MARGIN, height), "white")
    whole.paste(bodies, (MARGIN, (height - bodies.height) // 2))
    whole.paste(legend, (bodies.width + 2 * MARGIN, (height - legend.height) // 2))
    whole.save(file, optimize=True)


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
            test, which, settings, bare = PICTURES[name]
            if test not in made:
                made[test] = scenes_of(test, os.path.join(options.bin, "test_contact"), os.path.join(place, test))
            file = os.path.join(options.out, name + ".png")
            draw(os.path.join(options.bin, "stroma"), made[test][which], settings, bare, file)
            print(file)


if __name__ == "__main__":
    main()
