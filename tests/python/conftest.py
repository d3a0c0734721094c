# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the tests of the Python module share."""
import ctypes
import os
import pathlib
import signal
import sys

import pytest
import stroma

SOURCE = pathlib.Path(os.environ.get("STROMA_SOURCE", pathlib.Path(__file__).parents[2]))
EXAMPLES = SOURCE / "scenes" / "examples"
PATIENCE = float(os.environ.get("STROMA_TEST_PATIENCE", 600))  # seconds: only what hangs takes so long, whatever else a machine does

# A shell starts what it does not wait for with Ctrl-C ignored, and Python then leaves it so.
signal.signal(signal.SIGINT, signal.default_int_handler)


class HeapInfo(ctypes.Structure):
    """mallinfo2() of the C library: bytes."""
    _fields_ = [(name, ctypes.c_size_t) for name in ("arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks",
                                                     "fordblks", "keepcost")]


def held():
    """Bytes that somebody has and has not freed, of the C library's heap and of Python's. Pages are another matter: the kernel joins some
    to huge ones when it likes, and what is freed stays with the process."""
    mallinfo = ctypes.CDLL(None).mallinfo2
    mallinfo.restype = HeapInfo
    heap = mallinfo()
    return heap.uordblks + heap.hblkhd + 64 * sys.getallocatedblocks()


def block(**fem):
    """A block of 5 x 5 x 4 nodes that hangs from its top: small, and it moves."""
    root = stroma.Node("root", dt=0.01, gravity=(0, -9.81, 0))
    root.add("EulerImplicitSolver", name="solver", rayleighStiffness=0.01)
    root.add("CGLinearSolver", name="linear", iterations=50, tolerance=1e-10)
    body = root.add_child("body")
    body.add("RegularGridTopology", name="grid", n=(5, 5, 4), min=(0, 0, 0), max=(0.1, 0.1, 0.08))
    body.add("MechanicalObject", name="dofs")
    body.add("UniformMass", name="mass", totalMass=1)
    body.add("HexahedronFEMForceField", name="fem", **{"youngModulus": 5000, "poissonRatio": 0.3, "method": "large", **fem})
    body.add("BoxROI", name="top", box=(-1, 0.099, -1, 1, 0.101, 1))
    body.add("FixedProjectiveConstraint", name="held", indices="@top.indices")
    return root


@pytest.fixture
def simulation():
    return stroma.load(block())


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder that is the present one: examples write their results there."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
