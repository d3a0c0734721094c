#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Makes the example leg: a lower leg as a segmented voxel image, for `stroma mesh`.

A soft limb (label 1) with a calf, closed at both ends, holds a thick bone (label 2, with wider ends) and a thin one
(label 3) beside it. A voxel has the label of the shape at its centre. The same arguments give the same file, byte for byte.

  make_leg.py --out leg.mhd                MetaImage (leg.mhd and leg.raw); leg.mha: both in one file
  make_leg.py --out leg.nii.gz             NIfTI
  make_leg.py --out leg.vti                VTK image data
  make_leg.py --voxel 1.5 --out leg.mhd    voxels of 1.5 mm (default: 2 mm)

Lengths in the file are millimetres, as scanners give them; z points along the leg to the knee, y to the front. Needs numpy only. Exit codes: 0 written, 2 bad
arguments.
"""
import argparse
import base64
import gzip
import os
import struct
import sys

try:
    import numpy as np
except ImportError:
    print(f"{os.path.basename(__file__)}: error: the Python of {sys.executable} has no numpy: take another one, such as /usr/bin/python3 "
          "with Debian's python3-numpy, or install numpy for it", file=sys.stderr)
    sys.exit(2)

LENGTH = 0.36  # [m] from the ankle's end to the knee's
SOFT, TIBIA, FIBULA = 1, 2, 3


def capped(z, low, high, rounding):
    """Along the axis: 1 in the middle, falling like a quarter of an ellipse to 0 at both ends."""
    t = np.clip(np.maximum(low + rounding - z, z - high + rounding) / rounding, 0, None)
    return np.sqrt(np.clip(1 - t * t, 0, None))


def bump(z, centre, width):
    return np.exp(-(((z - centre) / width) ** 2))


def label_of(p):
    """The label at points p [m], shape (..., 3)."""
    x, y, z = p[..., 0], p[..., 1], p[..., 2]
    limb = (0.036 + 0.019 * bump(z, 0.24, 0.09) + 0.006 * bump(z, 0.34, 0.05)) * capped(z, 0, LENGTH, 0.035)
    calf = -0.010 * bump(z, 0.24, 0.09)  # the calf bulges to the back
    labels = np.where(x**2 + (1.1 * (y - calf)) ** 2 < limb**2, SOFT, 0)
    tibia = (0.0105 + 0.010 * bump(z, 0.325, 0.045) + 0.005 * bump(z, 0.030, 0.035)) * capped(z, 0.020, 0.345, 0.020)
    labels = np.where((x + 0.008) ** 2 + (y - 0.008) ** 2 < tibia**2, TIBIA, labels)
    fibula = (0.0055 + 0.003 * bump(z, 0.285, 0.025) + 0.003 * bump(z, 0.035, 0.025)) * capped(z, 0.020, 0.300, 0.010)
    return np.where((x - 0.020) ** 2 + (y + 0.008) ** 2 < fibula**2, FIBULA, labels).astype(np.uint8)


def leg(voxel):
    """Labels indexed [z, y, x], and the centre of the first voxel [mm]; `voxel` is the edge of a voxel [mm]."""
    low, high = np.array([-62.0, -66.0, -4.0]), np.array([62.0, 52.0, 1000 * LENGTH + 4])
    size = np.ceil((high - low) / voxel).astype(int)
    origin = low + voxel / 2
    x, y, z = (origin[k] + voxel * np.arange(size[k]) for k in range(3))
    zz, yy, xx = np.meshgrid(z, y, x, indexing="ij")
    return label_of(np.stack([xx, yy, zz], axis=-1) / 1000), origin


def write_meta(path, labels, origin, voxel):
    local = path.endswith(".mha")
    raw = "LOCAL" if local else os.path.basename(path)[:-4] + ".raw"
    sizes = " ".join(str(n) for n in labels.shape[::-1])
    header = (f"ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
              f"CompressedData = False\nTransformMatrix = 1 0 0 0 1 0 0 0 1\n"
              f"Offset = {origin[0]:.9g} {origin[1]:.9g} {origin[2]:.9g}\n"
              f"ElementSpacing = {voxel:.9g} {voxel:.9g} {voxel:.9g}\nDimSize = {sizes}\n"
              f"ElementType = MET_UCHAR\nElementDataFile = {raw}\n")
    with open(path, "wb") as file:
        file.write(header.encode())
        if local:
            file.write(labels.tobytes())
    if not local:
        with open(path[:-4] + ".raw", "wb") as file:
            file.write(labels.tobytes())


def write_nifti(path, labels, origin, voxel):
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *labels.shape[::-1], 1, 1, 1, 1)
    struct.pack_into("<hh", header, 70, 2, 8)  # unsigned char, 8 bits
    struct.pack_into("<8f", header, 76, 1, voxel, voxel, voxel, 0, 0, 0, 0)
    struct.pack_into("<f", header, 108, 352)
    struct.pack_into("<f", header, 112, 1)  # scl_slope
    header[123] = 2  # lengths in millimetres
    struct.pack_into("<hh", header, 252, 0, 1)  # sform only
    for k in range(3):
        row = [0.0] * 4
        row[k], row[3] = voxel, origin[k]
        struct.pack_into("<4f", header, 280 + 16 * k, *row)
    header[344:348] = b"n+1\0"
    data = bytes(header) + labels.tobytes()
    with open(path, "wb") as file:
        file.write(gzip.compress(data, mtime=0) if path.endswith(".gz") else data)


def write_vti(path, labels, origin, voxel):
    extent = " ".join(f"0 {n - 1}" for n in labels.shape[::-1])
    block = base64.b64encode(struct.pack("<Q", labels.size) + labels.tobytes()).decode()
    with open(path, "w", encoding="ascii") as file:
        file.write(f'<?xml version="1.0"?>\n<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" '
                   f'header_type="UInt64">\n<ImageData WholeExtent="{extent}" '
                   f'Origin="{origin[0]:.9g} {origin[1]:.9g} {origin[2]:.9g}" '
                   f'Spacing="{voxel:.9g} {voxel:.9g} {voxel:.9g}">\n<Piece Extent="{extent}">'
                   f'<PointData Scalars="labels"><DataArray type="UInt8" Name="labels" format="binary">{block}'
                   f'</DataArray></PointData></Piece>\n</ImageData>\n</VTKFile>\n')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", required=True, help="image to write: .mhd, .mha, .nii, .nii.gz or .vti")
    parser.add_argument("--voxel", type=float, default=2, help="edge of a voxel [mm]")
    arguments = parser.parse_args()
    if not 0.5 <= arguments.voxel <= 4:
        parser.error(f"--voxel {arguments.voxel}: expected 0.5 to 4 (the thin bone is 11 mm thick)")
    writers = {".mhd": write_meta, ".mha": write_meta, ".nii": write_nifti, ".nii.gz": write_nifti, ".vti": write_vti}
    suffix = next((s for s in writers if arguments.out.endswith(s)), None)
    if suffix is None:
        parser.error(f"--out {arguments.out}: expected a name that ends with {', '.join(writers)}")
    labels, origin = leg(arguments.voxel)
    writers[suffix](arguments.out, labels, origin, arguments.voxel)
    counts = [int((labels == label).sum()) for label in (SOFT, TIBIA, FIBULA)]
    sizes = "x".join(str(n) for n in labels.shape[::-1])
    print(f"{arguments.out}: {sizes} voxels; label 1 (soft) {counts[0]}, 2 (tibia) {counts[1]}, 3 (fibula) {counts[2]}")


if __name__ == "__main__":
    sys.exit(main())
