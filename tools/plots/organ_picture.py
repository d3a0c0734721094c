#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Draws the first and the last state of a recorded body side by side, as a picture to look at without ParaView.

  organ_picture.py FOLDER --out organ.png            reads the .pvd in FOLDER and the .vtu files it names
  organ_picture.py FOLDER --out organ.png --field displacement

The surface triangles are taken from the tetrahedra, shaded by a light from the upper left and drawn from back to front.
Colour is a cell field of the files (von Mises stress by default) or the length of the displacement. The same colour
scale serves both states. Needs numpy and matplotlib.
"""
import argparse
import base64
import os
import sys
import xml.etree.ElementTree as ElementTree
import zlib

import numpy as np

TYPES = {"Float64": "f8", "Float32": "f4", "Int64": "i8", "Int32": "i4", "UInt64": "u8", "UInt32": "u4", "UInt8": "u1",
         "Int8": "i1"}


# ---- a small reader of .vtu files: ASCII, inline base64 and appended data, plain or zlib ----

class VtuFile:
    def __init__(self, path):
        with open(path, "rb") as file:
            raw = file.read()
        self.path, self.appended, self.appended_is_raw = path, b"", False
        start = raw.find(b"<AppendedData")
        if start >= 0:
            begin = raw.index(b"_", raw.index(b">", start)) + 1
            end = raw.rindex(b"</AppendedData>")
            self.appended, self.appended_is_raw = raw[begin:end], b"raw" in raw[start:begin]
            raw = raw[:begin] + raw[end:]
        self.root = ElementTree.fromstring(raw)
        self.order = "<" if self.root.get("byte_order", "LittleEndian") == "LittleEndian" else ">"
        self.header = np.dtype(self.order + TYPES[self.root.get("header_type", "UInt32")])
        self.zlib = self.root.get("compressor") == "vtkZLibDataCompressor"
        if self.root.get("compressor") and not self.zlib:
            sys.exit(f"{path}: compressor {self.root.get('compressor')} is not read here (expected zlib or none)")

    def array(self, section, name=None):
        """The named array of a section (Points, Cells, PointData, CellData), or its first one; None when absent."""
        for element in self.root.iter(section):
            for data in element.findall("DataArray"):
                if name is None or data.get("Name") == name:
                    return self.values(data)
        return None

    def names(self, section):
        return [data.get("Name") for element in self.root.iter(section) for data in element.findall("DataArray")]

    def values(self, data):
        dtype = np.dtype(self.order + TYPES[data.get("type")])
        form = data.get("format", "ascii")
        if form == "ascii":
            values = np.array((data.text or "").split(), dtype=float).astype(dtype)
        elif form == "appended":
            offset = int(data.get("offset"))
            source = self.appended[offset:]
            values = np.frombuffer(self.unpack(source, not self.appended_is_raw), dtype)
        else:
            values = np.frombuffer(self.unpack((data.text or "").strip().encode(), True), dtype)
        components = int(data.get("NumberOfComponents", "1"))
        return values.reshape(-1, components) if components > 1 else values

    def unpack(self, source, encoded):
        """The bytes of one array: a header of block sizes, then the blocks."""
        width = self.header.itemsize

        def take(count):  # decodes just enough base64, as header and data are encoded separately
            nonlocal source
            if not encoded:
                piece, source = source[:count], source[count:]
                return piece
            length = (count + 2) // 3 * 4
            piece, source = base64.b64decode(source[:length]), source[length:]
            return piece[:count]

        if not self.zlib:
            # Header and data of an uncompressed array are encoded in one piece.
            size = int(np.frombuffer(base64.b64decode(source[:(width + 2) // 3 * 4])[:width] if encoded
                                     else source[:width], self.header)[0])
            return take(width + size)[width:]
        first = take(width) if not encoded else base64.b64decode(source[:(width + 2) // 3 * 4])[:width]
        blocks = int(np.frombuffer(first, self.header)[0])
        sizes = take((3 + blocks) * width) if encoded else first + take((2 + blocks) * width)
        sizes = np.frombuffer(sizes, self.header)[3:]
        packed = take(int(sizes.sum()))
        ends = np.cumsum(sizes)
        return b"".join(zlib.decompress(packed[int(end - size):int(end)]) for size, end in zip(sizes, ends))

    def tetrahedra(self):
        connectivity, offsets = self.array("Cells", "connectivity"), self.array("Cells", "offsets")
        kinds = self.array("Cells", "types")
        return np.array([connectivity[offsets[i] - 4:offsets[i]] for i in np.flatnonzero(kinds == 10)], int), \
            np.flatnonzero(kinds == 10)


def series(folder):
    """(time, path) of every file in the folder's .pvd, in order of time."""
    collections = sorted(name for name in os.listdir(folder) if name.endswith(".pvd")) if os.path.isdir(folder) else []
    if not collections:
        sys.exit(f"{folder}: no .pvd file there (run a scene with a VTKExporter first)")
    root = ElementTree.parse(os.path.join(folder, collections[0])).getroot()
    entries = sorted((float(entry.get("timestep")), entry.get("file")) for entry in root.iter("DataSet"))
    if not entries:
        sys.exit(f"{folder}/{collections[0]}: the collection is empty")
    return [(time, os.path.join(folder, name)) for time, name in entries]


# ---- drawing ----

def surface(tetrahedra, position):
    """Triangles of one tetrahedron only, turned outward, and the index of their tetrahedron."""
    found = {}
    for index, tet in enumerate(tetrahedra):
        for corner in range(4):
            face = [int(tet[i]) for i in range(4) if i != corner]
            key = tuple(sorted(face))
            found[key] = None if key in found else (face, int(tet[corner]), index)
    triangles, owners = [], []
    for face, opposite, index in (value for value in found.values() if value):
        a, b, c = position[face]
        if np.dot(np.cross(b - a, c - a), position[opposite] - a) > 0:
            face = face[::-1]
        triangles.append(face)
        owners.append(index)
    return np.array(triangles), np.array(owners)


def view(azimuth, elevation):
    """Rotation to the eye: right, up, towards the viewer; y of the scene is up."""
    a, e = np.radians(azimuth), np.radians(elevation)
    right = np.array([np.cos(a), 0, -np.sin(a)])
    towards = np.array([np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)])
    return np.array([right, np.cross(towards, right), towards])


def draw(axes, position, triangles, values, colours, norm, eye):
    from matplotlib.collections import PolyCollection
    corners = (position @ eye.T)[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    light = np.array([-0.45, 0.6, 0.66])
    shade = 0.42 + 0.58 * np.clip(normal @ (light / np.linalg.norm(light)), 0, 1)
    order = np.argsort(corners[:, :, 2].mean(axis=1))
    order = order[normal[order, 2] > 0]
    rgba = colours(norm(values))
    rgba[:, :3] *= shade[:, None]
    axes.add_collection(PolyCollection(corners[order, :, :2], facecolors=rgba[order], edgecolors=(0, 0, 0, 0.25),
                                       linewidths=0.35))
    return corners[:, :, :2].reshape(-1, 2)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="folder with the .pvd and .vtu files")
    parser.add_argument("--out", required=True, help="picture to write (.png, .pdf, .svg)")
    parser.add_argument("--field", default="vonMises", help="a cell field of the files, or: displacement")
    parser.add_argument("--azimuth", type=float, default=18, help="degrees about the vertical")
    parser.add_argument("--elevation", type=float, default=12, help="degrees above the horizon")
    arguments = parser.parse_args()

    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.colors import Normalize

    frames = series(arguments.folder)
    (first_time, first_path), (last_time, last_path) = frames[0], frames[-1]
    first, last = VtuFile(first_path), VtuFile(last_path)
    rest, moved = first.array("Points"), last.array("Points")
    tetrahedra, cells = first.tetrahedra()
    if len(tetrahedra) == 0:
        sys.exit(f"{first_path}: no tetrahedra to draw")
    if rest.shape != moved.shape:
        sys.exit(f"{last_path}: {len(moved)} points, but {first_path} has {len(rest)}")
    triangles, owners = surface(tetrahedra, rest)
    travel = np.linalg.norm(moved - rest, axis=1)

    if arguments.field == "displacement":
        values = [np.zeros(len(triangles)), travel[triangles].mean(axis=1) * 1e3]
        label = "displacement [mm]"
    else:
        fields = [file.array("CellData", arguments.field) for file in (first, last)]
        if any(field is None for field in fields):
            known = ", ".join(sorted(set(last.names("CellData")))) or "none"
            sys.exit(f"{last_path}: no cell field '{arguments.field}' (there: {known}; or use --field displacement)")
        values = [field[cells][owners] / 1e3 for field in fields]
        label = f"{'von Mises stress' if arguments.field == 'vonMises' else arguments.field} [kPa]"

    # The few cells at the held and pulled points stand far above the rest: cut the scale there, and say so.
    top = float(np.percentile(values[1], 98)) or 1.0
    norm, colours = Normalize(0, top, clip=True), pyplot.get_cmap("YlOrRd")
    eye = view(arguments.azimuth, arguments.elevation)
    flat = np.concatenate([rest, moved]) @ eye.T[:, :2]
    aspect = float(np.ptp(flat[:, 1]) / np.ptp(flat[:, 0]))
    figure, axes = pyplot.subplots(1, 2, figsize=(10, 1.2 + 4.2 * aspect), sharex=True, sharey=True)
    drawn = [draw(panel, position, triangles, value, colours, norm, eye)
             for panel, position, value in zip(axes, (rest, moved), values)]
    everything = np.concatenate(drawn)
    low, high = everything.min(axis=0), everything.max(axis=0)
    margin = 0.05 * (high - low).max()
    for panel, time in zip(axes, (first_time, last_time)):
        panel.set_xlim(low[0] - margin, high[0] + margin)
        panel.set_ylim(low[1] - margin, high[1] + margin)
        panel.set_aspect("equal")
        panel.axis("off")
        panel.set_title(f"t = {time:g} s", fontsize=11)
    bar = figure.colorbar(pyplot.cm.ScalarMappable(norm, colours), ax=axes, shrink=0.75, extend="max")
    bar.set_label(label)
    figure.text(0.02, 0.03, f"{len(rest)} nodes, {len(tetrahedra)} tetrahedra; largest displacement "
                f"{travel.max() * 1e3:.1f} mm; colours per cell, scale cut at 98 % of the surface "
                f"(largest {values[1].max():.3g}).", fontsize=8)
    os.makedirs(os.path.dirname(os.path.abspath(arguments.out)), exist_ok=True)
    figure.savefig(arguments.out, dpi=130, bbox_inches="tight", metadata={"Software": None})
    print(f"written: {arguments.out} ({label}, t = {first_time:g} and {last_time:g} s)")


if __name__ == "__main__":
    main()
