# SPDX-License-Identifier: LGPL-2.1-or-later
"""A scene as a class with annotations, whose method is createScene; enumerations, named tuples and a context manager of its own."""
from __future__ import annotations

import contextlib
from typing import Dict, List, NamedTuple, Optional, Tuple

import numpy as np
import numpy.typing as npt
import Sofa
from Sofa.Core import Controller, Node, Object


class Material(NamedTuple):
    young: float
    poisson: float = 0.3

    def as_kwargs(self) -> Dict[str, float]:
        return {"youngModulus": self.young, "poissonRatio": self.poisson}


class Builder:
    def __init__(self, root: Node) -> None:
        self.root: Node = root
        self.parts: List[Tuple[str, Object]] = []

    @contextlib.contextmanager
    def node(self, name: str, parent: Optional[Node] = None):
        child: Node = (parent or self.root).addChild(name)
        try:
            yield child
        finally:
            self.parts += [(name, each) for each in child.objects]

    def build(self) -> Node:
        self.root.addObject("DefaultAnimationLoop")
        with self.node("body") as body:
            body.addObject("EulerImplicitSolver")
            body.addObject("CGLinearSolver", iterations=40, tolerance=1e-9, threshold=1e-9)
            body.addObject("RegularGridTopology", n=(3, 3, 5), min=(0, 0, 0), max=(1, 1, 2))
            body.addObject("MechanicalObject", name="state")
            body.addObject("UniformMass", totalMass=1.)
            body.addObject("HexahedronFEMForceField", **Material(4e3).as_kwargs())
            body.addObject("FixedProjectiveConstraint", indices=np.arange(9, dtype=np.uint32))
        self.root.addObject(Watch(self, name="watch"))
        return self.root

    def positions(self) -> npt.NDArray[np.float64]:
        return self.root.body.state.position.array()


class Watch(Controller):
    def __init__(self, builder: Builder, *args, **kwargs) -> None:
        super().__init__(*args, **kwargs)
        self.builder = builder
        self.lowest: List[float] = []

    def onAnimateEndEvent(self, _: dict) -> None:
        self.lowest.append(float(self.builder.positions()[:, 1].min()))
        match len(self.lowest):
            case 1:
                assert self.lowest[0] < 0
            case n if n > 1:
                assert self.lowest[-1] != self.lowest[-2]


def createScene(root: Node) -> Node:
    return Builder(root).build()
