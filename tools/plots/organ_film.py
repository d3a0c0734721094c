#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Makes an animated GIF of a recorded body, to look at without ParaView.

  organ_film.py FOLDER --out organ.gif                            reads the .pvd in FOLDER and the .vtu files it names
  organ_film.py FOLDER --out organ.gif --from 1 --to 3 --speed 0.5

docs/organ.gif is made by
  build/release/bin/stroma run scenes/examples/organ_pulled.xml -n 350
  tools/plots/organ_film.py results/organ_pulled --out docs/organ.gif --from 1.15

One frame per file, at the speed of the simulated time unless --speed says otherwise. The surface is shaded with smooth
normals; its colour is the von Mises stress, averaged from the cells to the nodes. Needs numpy, matplotlib and Pillow, which
matplotlib brings.
"""
import argparse
import io
import os
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import organ_picture  # noqa: E402

WIDTH, HEIGHT, FINER = 520, 300, 2  # of a frame in pixels; FINER x FINER samples per pixel
LIGHT = np.array([-0.45, 0.65, 0.62])
BACKGROUND = np.array([1.0, 1.0, 1.0])


def node_normals(position, triangles):
    """Unit normals of the nodes of a surface: the sum over their triangles, weighted by area."""
    a, b, c = (position[triangles[:, i]] for i in range(3))
    of_triangles = np.cross(b - a, c - a)
    normals = np.zeros_like(position)
    for corner in range(3):
        np.add.at(normals, triangles[:, corner], of_triangles)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)


def node_values(cells, cell_values, count):
    """Mean over the tetrahedra around each node."""
    total, number = np.zeros(count), np.zeros(count)
    for corner in range(4):
        np.add.at(total, cells[:, corner], cell_values)
        np.add.at(number, cells[:, corner], 1)
    return total / np.maximum(number, 1)


def rasterise(corners, attributes, width, height):
    """Draws triangles with a depth buffer. corners: (n, 3, 3), pixels and depth towards the viewer; attributes: (n, 3, k),
    linear over a triangle. Returns (height, width, k) and the depth, -inf where nothing was drawn."""
    image = np.zeros((height, width, attributes.shape[2]))
    depth = np.full((height, width), -np.inf)
    for points, values in zip(corners, attributes):
        low = np.maximum(np.floor(points[:, :2].min(axis=0)).astype(int), 0)
        high = np.minimum(np.ceil(points[:, :2].max(axis=0)).astype(int) + 1, [width, height])
        if (high <= low).any():
            continue
        edges = np.array([points[1, :2] - points[0, :2], points[2, :2] - points[0, :2]]).T
        area = edges[0, 0] * edges[1, 1] - edges[0, 1] * edges[1, 0]
        if abs(area) < 1e-12:
            continue
        x, y = np.meshgrid(np.arange(low[0], high[0]) + 0.5 - points[0, 0], np.arange(low[1], high[1]) + 0.5 - points[0, 1])
        u = (edges[1, 1] * x - edges[0, 1] * y) / area
        v = (edges[0, 0] * y - edges[1, 0] * x) / area
        weights = np.stack([1 - u - v, u, v], axis=-1)
        there = depth[low[1]:high[1], low[0]:high[0]]
        here = weights @ points[:, 2]
        seen = (weights >= -1e-9).all(axis=-1) & (here > there)
        there[seen] = here[seen]
        image[low[1]:high[1], low[0]:high[0]][seen] = weights[seen] @ values
    return image, depth


def shaded(position, triangles, colours, to_pixels, eye):
    """RGB picture of the surface, (HEIGHT, WIDTH, 3)."""
    seen = position @ eye.T
    corners = seen[triangles]
    corners[:, :, :2] = to_pixels(corners[:, :, :2]) * FINER
    normals = node_normals(seen, triangles)
    values = np.concatenate([colours[triangles], normals[triangles]], axis=2)
    image, depth = rasterise(corners, values, WIDTH * FINER, HEIGHT * FINER)
    normal = image[:, :, 3:]
    normal = normal / np.maximum(np.linalg.norm(normal, axis=2, keepdims=True), 1e-30)
    light = LIGHT / np.linalg.norm(LIGHT)
    half = light + [0, 0, 1]
    half = half / np.linalg.norm(half)
    diffuse = 0.45 + 0.6 * np.clip(normal @ light, 0, 1)
    gloss = 0.22 * np.clip(normal @ half, 0, 1) ** 40
    rgb = np.clip(image[:, :, :3] * diffuse[:, :, None] + gloss[:, :, None], 0, 1)
    rgb = np.where(np.isfinite(depth)[:, :, None], rgb, BACKGROUND)
    return rgb.reshape(HEIGHT, FINER, WIDTH, FINER, 3).mean(axis=(1, 3))


class Film:
    """The frames of a folder, with one view and one scale of colours for all."""

    def __init__(self, folder, arguments):
        chosen = [(time, path) for time, path in organ_picture.series(folder)
                  if arguments.start <= time + 1e-9 and time - 1e-9 <= arguments.end]
        if len(chosen) < 2:
            sys.exit(f"{folder}: {len(chosen)} files between t = {arguments.start:g} and {arguments.end:g} s; a film needs two")
        self.times = [time for time, _ in chosen]
        files = [organ_picture.VtuFile(path) for _, path in chosen]
        cells, chosen_cells = files[0].tetrahedra()
        if len(cells) == 0:
            sys.exit(f"{chosen[0][1]}: no tetrahedra to draw")
        self.tetrahedra = len(cells)
        self.positions = [file.array("Points") for file in files]
        stresses = [file.array("CellData", arguments.field) for file in files]
        if any(stress is None for stress in stresses):
            sys.exit(f"{chosen[0][1]}: no cell field '{arguments.field}' "
                     f"(there: {', '.join(files[0].names('CellData')) or 'none'})")
        self.values = [node_values(cells, stress[chosen_cells] / 1e3, len(self.positions[0])) for stress in stresses]
        # Turned outward in a shape of the film itself; the shape at rest need not be among the files.
        self.triangles, _ = organ_picture.surface(cells, self.positions[0])
        self.eye = organ_picture.view(arguments.azimuth, arguments.elevation)
        on_surface = np.unique(self.triangles)
        self.top = float(np.percentile([values[on_surface] for values in self.values], 99.5)) or 1.0
        seen = np.concatenate([position[on_surface] @ self.eye.T[:, :2] for position in self.positions])
        self.low, self.high = seen.min(axis=0), seen.max(axis=0)

    def to_pixels(self, points):
        """Right and up of the view [m] to pixels from the upper left corner, with room for the scale and a margin."""
        scale = min((WIDTH - 130) / (self.high - self.low)[0], (HEIGHT - 60) / (self.high - self.low)[1])
        middle = (self.low + self.high) / 2
        return (points - middle) * [scale, -scale] + [(WIDTH - 90) / 2, (HEIGHT + 10) / 2]

    def frame(self, index, norm, colours):
        rgb = colours(norm(self.values[index]))[:, :3]
        return shaded(self.positions[index], self.triangles, rgb, self.to_pixels, self.eye)


def drawn(film, arguments):
    """All frames as Pillow images, with the time and the scale of colours."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.colors import Normalize
    from PIL import Image

    norm, colours = Normalize(0, film.top, clip=True), pyplot.get_cmap("YlOrRd")
    figure = pyplot.figure(figsize=(WIDTH / 100, HEIGHT / 100), dpi=100)
    axes = figure.add_axes([0, 0, 1, 1])
    axes.axis("off")
    picture = axes.imshow(np.ones((HEIGHT, WIDTH, 3)), interpolation="nearest", aspect="auto")
    scale = figure.add_axes([0.9, 0.18, 0.018, 0.6])
    bar = figure.colorbar(pyplot.cm.ScalarMappable(norm, colours), cax=scale, extend="max")
    bar.ax.tick_params(labelsize=8)
    bar.ax.set_title("von Mises\nstress [kPa]" if arguments.field == "vonMises" else f"{arguments.field}\n[k]", fontsize=8)
    clock = figure.text(0.025, 0.92, "", fontsize=10, family="monospace")
    figure.text(0.025, 0.04, f"{film.tetrahedra} tetrahedra", fontsize=8, color="0.35")
    images = []
    for index, time in enumerate(film.times):
        picture.set_data(film.frame(index, norm, colours))
        clock.set_text(f"t = {time - film.times[0]:4.2f} s")
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", dpi=100)
        images.append(Image.open(buffer).convert("RGB"))
    return images


def palette_of(images, count):
    """A palette for all frames, with pure white for the background. A colour counts by the root of the number of its pixels:
    the few dark red ones matter, too."""
    from PIL import Image
    pixels = np.concatenate([np.asarray(image).reshape(-1, 3) for image in images])
    used, number = np.unique(pixels[(pixels < 248).any(axis=1)] // 4, axis=0, return_counts=True)
    strip = np.repeat(used * 4 + 2, np.ceil(np.sqrt(number)).astype(int), axis=0).astype(np.uint8)
    chosen = Image.fromarray(strip[None, :, :]).quantize(count - 1, method=Image.Quantize.MEDIANCUT)
    palette = Image.new("P", (1, 1))
    palette.putpalette(chosen.getpalette()[:3 * (count - 1)] + [255, 255, 255] * (257 - count))
    return palette


def save(images, times, arguments):
    """The same palette for all frames, so that pixels that stay the same compress to nothing."""
    from PIL import Image
    palette = palette_of(images, arguments.colours)
    frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    durations = [max(20, round(1000 * (later - now) / arguments.speed / 10) * 10) for now, later in zip(times, times[1:])]
    durations.append(800)  # [ms] a rest at the end
    frames[0].save(arguments.out, save_all=True, append_images=frames[1:], duration=durations, loop=0, optimize=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="folder with the .pvd and .vtu files")
    parser.add_argument("--out", required=True, help="animated GIF to write")
    parser.add_argument("--field", default="vonMises", help="a cell field of the files [Pa]")
    parser.add_argument("--from", dest="start", type=float, default=-np.inf, help="first time [s]; shown as zero")
    parser.add_argument("--to", dest="end", type=float, default=np.inf, help="last time [s]")
    parser.add_argument("--speed", type=float, default=1, help="seconds of the simulation per second of the film")
    parser.add_argument("--colours", type=int, default=96, help="colours of the palette; fewer make a smaller file")
    parser.add_argument("--azimuth", type=float, default=18, help="degrees about the vertical")
    parser.add_argument("--elevation", type=float, default=14, help="degrees above the horizon")
    arguments = parser.parse_args()
    if not arguments.speed > 0:
        parser.error(f"--speed {arguments.speed:g}: expected more than 0")
    film = Film(arguments.folder, arguments)
    images = drawn(film, arguments)
    os.makedirs(os.path.dirname(os.path.abspath(arguments.out)), exist_ok=True)
    save(images, film.times, arguments)
    print(f"written: {arguments.out} ({len(images)} frames, t = {film.times[0]:g} to {film.times[-1]:g} s, "
          f"{os.path.getsize(arguments.out) / 1000:.0f} kB)")


if __name__ == "__main__":
    main()
