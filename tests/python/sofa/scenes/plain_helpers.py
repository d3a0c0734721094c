# SPDX-License-Identifier: LGPL-2.1-or-later
"""A file of helpers that return dictionaries of nodes; setattr and getattr on nodes; loops over objects; copies of lists."""
import copy
from collections import OrderedDict
from functools import partial

import Sofa

DEFAULT = OrderedDict(totalMass=0.5, youngModulus=900., poissonRatio=.3)


def add_solvers(node, kind="direct", /, *, damping=(0.1, 0.1)):
    node.addObject("EulerImplicitSolver", rayleighMass=damping[0], rayleighStiffness=damping[1])
    return {"direct": partial(node.addObject, "SparseLDLSolver", template="CompressedRowSparseMatrixMat3x3"),
            "cg": partial(node.addObject, "CGLinearSolver", iterations=30, tolerance=1e-8, threshold=1e-8)}[kind]()


def add_body(parent, params=DEFAULT, **override):
    params = {**copy.deepcopy(params), **override}
    node = parent.addChild(params.pop("name", "body"))
    add_solvers(node, params.pop("solver", "direct"))
    grid = node.addObject("RegularGridTopology", n=params.pop("n", [3, 3, 3]), min=[0] * 3, max=[1] * 3)
    state = node.addObject("MechanicalObject", position=grid.position.value.tolist())
    mass = node.addObject("UniformMass", totalMass=params.pop("totalMass"))
    fem = node.addObject("HexahedronFEMForceField", **params)
    return {"node": node, "grid": grid, "state": state, "mass": mass, "fem": fem}


class Sweep(Sofa.Core.Controller):
    bodies: list = None

    def onAnimateBeginEvent(self, event: dict) -> None:
        for k, body in enumerate(self.bodies):
            body["fem"].youngModulus.value = 900 + 10 * k * self.getContext().getTime()
            for each in body["node"].objects:
                if isinstance(each, Sofa.Core.ForceField):
                    assert each.youngModulus.value >= 900

    def __str__(self):
        return "sweep"


def createScene(root, *args, **kwargs):
    root.addObject("DefaultAnimationLoop")
    bodies = [add_body(root, name=f"body{k}", solver=("direct", "cg")[k % 2], n=[3, 3, 3 + k]) for k in range(3)]
    for body in bodies:
        setattr(root, "held_" + body["node"].name.value, body["node"].addObject("FixedProjectiveConstraint", indices=[0, 1, 2]))
    assert getattr(root, "held_body1").indices.value.tolist() == [0, 1, 2]
    sweep = Sweep()
    sweep.bodies = bodies
    root.addObject(sweep)
    assert sorted(each.getName() for each in root.children) == ["body0", "body1", "body2"] and str(sweep) == "sweep"
    assert {each.getName(): each for each in root.getChildren()}["body2"].getObject("RegularGridTopology") is bodies[2]["grid"]
    return bodies
