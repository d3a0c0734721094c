# SPDX-License-Identifier: LGPL-2.1-or-later
"""Hexahedra by loops of Python, statics, and Timoshenko's deflection of the end as what the controller expects."""
from itertools import product

import numpy as np
import Sofa


def grid(nx, ny, nz, h):
    def index(i, j, k):
        return i + nx * (j + ny * k)
    points = [[i * h, j * h, k * h] for k, j, i in product(range(nz), range(ny), range(nx))]
    corners = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
    cells = [[index(i + a, j + b, k + c) for a, b, c in corners]
             for k, j, i in product(range(nz - 1), range(ny - 1), range(nx - 1))]
    return points, cells


def createScene(root):
    points, cells = grid(21, 5, 5, .025)
    root.gravity = [0, 0, 0]
    root.addObject('DefaultAnimationLoop')
    n = root.addChild('beam')
    n.addObject('StaticSolver', newton_iterations=20, relative_correction_tolerance_threshold=1e-8)
    n.addObject('SparseLDLSolver')
    n.addObject('HexahedronSetTopologyContainer', position=points, hexahedra=cells, name='topo')
    n.addObject('HexahedronSetGeometryAlgorithms')
    n.addObject('MechanicalObject', name='mo')
    n.addObject('HexahedronFEMForceField', youngModulus=1e5, poissonRatio=0., method='large')
    n.addObject('FixedConstraint', indices=[i for i, p in enumerate(points) if p[0] == 0])
    tip = [i for i, p in enumerate(points) if abs(p[0] - .5) < 1e-9]
    n.addObject('ConstantForceField', indices=tip, totalForce=[0, -1e-3, 0])

    class Check(Sofa.Core.Controller):
        def onAnimateEndEvent(self, e):
            moved = n.mo.position.value[tip][:, 1] - np.array(points)[tip][:, 1]
            second_moment, area = .1 ** 4 / 12, .01
            expected = 1e-3 * .5 ** 3 / 3 / 1e5 / second_moment + 1e-3 * .5 / (5 / 6 * 5e4 * area)
            assert abs(-moved.mean() / expected - 1) < 0.04, (moved.mean(), expected)
    root.addObject(Check())
