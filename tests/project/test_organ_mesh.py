#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The organ meshes of the examples are good meshes, and their tool still makes them, byte for byte; so does that of the skin."""
import filecmp
import os
import subprocess
import sys
import tempfile

try:
    import numpy as np
except ImportError:
    print("numpy is not installed")
    sys.exit(77)

sys.path.insert(0, os.path.join(sys.argv[1], "scenes", "meshes"))
sys.dont_write_bytecode = True
import make_organ  # noqa: E402

MESHES = os.path.join(sys.argv[1], "scenes", "meshes")


def check_stored():
    for name, count in (("organ_600.msh", 600), ("organ_5000.msh", 5000)):
        position, tetrahedra = make_organ.read_msh(os.path.join(MESHES, name))
        assert abs(len(tetrahedra) - count) < 0.05 * count, (name, len(tetrahedra))
        assert sorted(set(tetrahedra.ravel())) == list(range(len(position))), name
        assert make_organ.report(position, tetrahedra), f"{name} is not good enough"
        size = position.max(axis=0) - position.min(axis=0)
        assert 0.18 < size[0] < 0.22, (name, size)
        # Inside and outside agree with the implicit shape: no node is farther from the body than a share of a cell.
        assert make_organ.organ(position).max() < 0.002, name


def check_judgement():
    """The report must be able to say no: an inverted cell, a flat one, two separate bodies."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [5, 0, 0], [6, 0, 0], [5, 1, 0], [5, 0, 1],
                        [0.3, 0.3, 0.001]], float)
    assert make_organ.report(corners, np.array([[0, 1, 2, 3]]))
    assert not make_organ.report(corners, np.array([[1, 0, 2, 3]]))
    assert not make_organ.report(corners, np.array([[0, 1, 2, 8]]))
    assert not make_organ.report(corners, np.array([[0, 1, 2, 3], [4, 5, 6, 7]]))
    regular = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], float)
    assert np.allclose(make_organ.dihedral_angles(regular[None]), np.degrees(np.arccos(1 / 3)))


def check_tool():
    with tempfile.TemporaryDirectory() as folder:
        made = os.path.join(folder, "organ.vtk")
        tool = os.path.join(sys.argv[1], "scenes", "meshes", "make_organ.py")
        subprocess.run([sys.executable, tool, "--tets", "300", "--out", made], check=True)
        assert filecmp.cmp(made, os.path.join(MESHES, "organ_300.vtk"), shallow=False), "organ_300.vtk has changed"
        assert subprocess.run([sys.executable, tool, "--tets", "5", "--out", made], capture_output=True).returncode == 2


def check_skin():
    with tempfile.TemporaryDirectory() as folder:
        made = os.path.join(folder, "skin.msh")
        tool = os.path.join(sys.argv[1], "scenes", "meshes", "make_skin.py")
        subprocess.run([sys.executable, tool, "--out", made], check=True)
        assert filecmp.cmp(made, os.path.join(MESHES, "skin.msh"), shallow=False), "skin.msh has changed"
        assert subprocess.run([sys.executable, tool, "--cells", "5", "--out", made], capture_output=True).returncode == 2


check_stored()
check_judgement()
check_tool()
check_skin()
