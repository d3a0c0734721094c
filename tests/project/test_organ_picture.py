#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The picture tool reads every form of .vtu, draws a picture, and says what is wrong when it cannot.
Usage: test_organ_picture.py TREE STROMA"""
import base64
import os
import struct
import subprocess
import sys
import tempfile
import zlib

try:
    import matplotlib  # noqa: F401
    import numpy as np
except ImportError as problem:
    print(problem)
    sys.exit(77)

TOOL = os.path.join(sys.argv[1], "tools", "plots", "organ_picture.py")
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(TOOL))
import organ_picture  # noqa: E402

POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], float)
CELLS = np.array([[0, 1, 2, 3], [1, 2, 3, 4]])


def vtu(points, stress, form):
    """A file with two tetrahedra whose arrays are stored as `form` says."""
    appended = b""

    def pack(values):
        raw = values.tobytes()
        if "zlib" not in form:
            head = struct.pack("<Q", len(raw)) + raw
            return head if "raw" in form else base64.b64encode(head)
        half = (len(raw) + 1) // 2
        blocks = [zlib.compress(raw[:half]), zlib.compress(raw[half:])]
        head = struct.pack("<5Q", 2, half, len(raw) - half, *map(len, blocks))
        data = b"".join(blocks)
        return head + data if "raw" in form else base64.b64encode(head) + base64.b64encode(data)

    def array(name, kind, values, components=1):
        nonlocal appended
        head = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" '
        if form == "ascii":
            return head + 'format="ascii">' + " ".join(map(repr, values.ravel().tolist())) + "</DataArray>"
        if "appended" in form:
            offset = len(appended)
            appended += pack(values)
            return head + f'format="appended" offset="{offset}"/>'
        return head + 'format="binary">' + pack(values).decode() + "</DataArray>"

    body = ("<Points>" + array("Points", "Float64", points, 3) + "</Points><Cells>"
            + array("connectivity", "Int64", CELLS.astype("i8")) + array("offsets", "Int64", np.array([4, 8], "i8"))
            + array("types", "UInt8", np.array([10, 10], "u1")) + "</Cells><CellData>"
            + array("vonMises", "Float64", stress) + "</CellData>")
    tail = b""
    if appended:
        tail = b'<AppendedData encoding="' + (b"raw" if "raw" in form else b"base64") + b'">_' + appended + b"</AppendedData>"
    compressor = ' compressor="vtkZLibDataCompressor"' if "zlib" in form else ""
    return (f'<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
            f'header_type="UInt64"{compressor}><UnstructuredGrid><Piece NumberOfPoints="5" NumberOfCells="2">{body}'
            f"</Piece></UnstructuredGrid>").encode() + tail + b"</VTKFile>"


def draw(folder, *options):
    picture = os.path.join(folder, "out.png")
    result = subprocess.run([sys.executable, TOOL, folder, "--out", picture, *options], capture_output=True, text=True)
    return result, picture


def check_reader():
    forms = ["ascii", "inline", "inline zlib", "appended raw", "appended raw zlib", "appended base64", "appended base64 zlib"]
    moved = POINTS + [0, 0.5, 0]
    for form in forms:
        with tempfile.TemporaryDirectory() as folder:
            for name, points, stress in (("a0.vtu", POINTS, [0.0, 0.0]), ("a1.vtu", moved, [1000.0, 2000.0])):
                with open(os.path.join(folder, name), "wb") as file:
                    file.write(vtu(points, np.array(stress), form))
            read = organ_picture.VtuFile(os.path.join(folder, "a1.vtu"))
            assert np.array_equal(read.array("Points"), moved), form
            assert np.array_equal(read.tetrahedra()[0], CELLS), form
            assert np.array_equal(read.array("CellData", "vonMises"), [1000, 2000]), form
            with open(os.path.join(folder, "a.pvd"), "w", encoding="ascii") as file:
                file.write('<VTKFile type="Collection"><Collection><DataSet timestep="10" file="a1.vtu"/>'
                           '<DataSet timestep="9" file="a0.vtu"/></Collection></VTKFile>')
            result, picture = draw(folder)
            assert result.returncode == 0 and "t = 9 and 10 s" in result.stdout, result
            with open(picture, "rb") as file:
                assert file.read(8) == b"\x89PNG\r\n\x1a\n"
            result, _ = draw(folder, "--field", "heat")
            assert result.returncode != 0 and "vonMises" in result.stderr, result


def check_surface():
    triangles, owners = organ_picture.surface(CELLS, POINTS)
    assert len(triangles) == 6 and sorted(owners.tolist()) == [0, 0, 0, 1, 1, 1]
    centre = POINTS[CELLS].mean(axis=1)
    for triangle, owner in zip(triangles, owners):
        a, b, c = POINTS[triangle]
        assert np.dot(np.cross(b - a, c - a), a - centre[owner]) > 0, triangle


def check_scene():
    with tempfile.TemporaryDirectory() as folder:
        result, _ = draw(folder)
        assert result.returncode != 0 and "no .pvd" in result.stderr, result
        scene = os.path.join(os.path.abspath(sys.argv[1]), "scenes", "examples", "organ.xml")
        subprocess.run([os.path.abspath(sys.argv[2]), "run", scene, "-n", "10"], check=True, cwd=folder)
        result, picture = draw(os.path.join(folder, "results", "organ"))
        assert result.returncode == 0 and os.path.getsize(picture) > 10000, result


check_reader()
check_surface()
check_scene()
