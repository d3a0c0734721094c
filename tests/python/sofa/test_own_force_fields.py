# SPDX-License-Identifier: LGPL-2.1-or-later
"""Force fields that a scene writes in Python, on many nodes."""
import tracemalloc

import numpy as np
import pytest
import Sofa
from playing import animate

STIFFNESS, MASS, H = 1e4, 2.0, 0.01


class Rest(Sofa.Core.ForceFieldVec3d):
    """Springs to where the points start, of a stiffness that addForce() keeps for its derivative."""
    calls = 0

    def init(self):
        self.start = self.mstate.position.array().copy()

    def addForce(self, m, force, position, velocity):
        self.kept = STIFFNESS
        with force.writeableArray() as f:
            f[:] += self.kept * (self.start - position.value)

    def addDForce(self, m, df, dx):
        type(self).calls += 1
        with df.writeableArray() as f:
            f[:] -= self.kept * dx.value * m["kFactor"]


class Triplets(Rest):
    def addKToMatrix(self, m, nodes, numbers):
        return [(i, i, -self.kept) for i in range(nodes * numbers)]


class Chain(Rest):
    """Each point is pulled to the next one."""
    def addForce(self, m, force, position, velocity):
        with force.writeableArray() as f:
            f[:-1] += position.value[1:] - position.value[:-1]
            f[1:] -= position.value[1:] - position.value[:-1]

    def addDForce(self, m, df, dx):
        with df.writeableArray() as f:
            f[:-1] += dx.value[1:] - dx.value[:-1]
            f[1:] -= dx.value[1:] - dx.value[:-1]


def falling(kind, nodes):
    root = Sofa.Core.Node("root")
    root.dt = H
    node = root.addChild("body")
    node.addObject("EulerImplicitSolver")
    node.addObject("SparseLDLSolver")
    node.addObject("MechanicalObject", name="state", position=np.arange(3.0 * nodes).reshape(-1, 3))
    node.addObject("UniformMass", vertexMass=MASS)
    node.addObject(kind(name="own"))
    Sofa.Simulation.init(root)
    return root, node.state


def swung(steps):
    """Implicit Euler of one point."""
    y = v = 0.0
    for _ in range(steps):
        v = (v + H * (-9.81 - STIFFNESS / MASS * y)) / (1 + H ** 2 * STIFFNESS / MASS)
        y += H * v
    return y


@pytest.mark.parametrize("kind, nodes", [(Rest, 2), (Rest, 100), (Rest, 500), (Triplets, 2), (Triplets, 2000)])
def test_the_derivative_of_many_nodes_counts(kind, nodes):
    kind.calls = 0
    tracemalloc.start()
    root, state = falling(kind, nodes)
    animate(root, 5)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    fallen = state.position.value - np.arange(3.0 * nodes).reshape(-1, 3)
    assert fallen == pytest.approx(np.tile([0, swung(5), 0], (nodes, 1)), abs=1e-9)
    assert kind.calls <= 4 * 7, "three ways that tell the blocks and one that tells whether they do"
    assert peak < 100e6, "no matrix of all numbers by all numbers"


def test_nodes_that_a_product_couples(capsys):
    """As a matrix where they are few; else the force is that at the start, and a sentence says so."""
    root, state = falling(Chain, 60)
    animate(root, 3)
    assert "addDForce() is not used" not in capsys.readouterr().err and np.isfinite(state.position.value).all()
    root, state = falling(Chain, 150)
    animate(root, 3)
    assert "/body/own: addDForce() is not used for 150 nodes that it couples" in capsys.readouterr().err


class Later(Rest):
    """Couples nodes from some step on."""
    def addDForce(self, m, df, dx):
        super().addDForce(m, df, dx)
        with df.writeableArray() as f:
            if self.getRoot().getTime() > 0.015:
                f[0] -= dx.value[1]


def test_a_product_that_couples_nodes_later_is_told():
    root, _ = falling(Later, 150)
    with pytest.raises(Exception, match="addDForce.. couples nodes, and did not before"):
        animate(root, 5)


@pytest.mark.parametrize("number", [12, -1, 0.5, float("nan")])
def test_rows_that_the_matrix_does_not_have_are_told(number):
    class Beyond(Rest):
        def addKToMatrix(self, m, nodes, numbers):
            return [(0, 0, -self.kept), (number, 1, 0)]
    root, _ = falling(Beyond, 4)
    with pytest.raises(ValueError, match=f"addKToMatrix.. names row or column {number:g} of a matrix of 12"):
        animate(root, 1)
