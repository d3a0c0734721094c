# SPDX-License-Identifier: LGPL-2.1-or-later
"""A robot as a class of Python, paths by pathlib, links as linkpath, a class of a controller within createScene()."""
from pathlib import Path

import Sofa

DIR = Path(__file__).resolve().parent / "mesh"


class Robot:
    def __init__(self, root, **kw):
        self.root = root
        self.cfg = {**dict(mu=1000, k0=4000), **kw}

    def build(self):
        n = self.node = self.root.addChild("robot")
        n.addObject("EulerImplicitSolver", rayleighMass=.1, rayleighStiffness=.1)
        n.addObject("SparseLDLSolver", name="ldl", template="CompressedRowSparseMatrixMat3x3")
        n.addObject("GenericConstraintCorrection", linearSolver="@ldl")
        n.addObject("MeshVTKLoader", name="loader", filename=str(DIR / "finger.vtk"))
        n.addObject("TetrahedronSetTopologyContainer", src=n.loader.linkpath, name="topo")
        n.addObject("MechanicalObject", name="mo")
        n.addObject("MeshMatrixMass", totalMass=.05, topology="@topo")
        n.addObject("TetrahedronHyperelasticityFEMForceField", materialName="StableNeoHookean", ParameterSet=[self.cfg["mu"], self.cfg["k0"]])
        n.addObject("BoxROI", name="fix", box=[-1, -1, -1, 1, 21, 21])
        n.addObject("FixedProjectiveConstraint", indices=n.fix.indices.linkpath)
        return self

    def cable(self, name, line, pull):
        c = self.node.addChild(name)
        c.addObject("MechanicalObject", position=line, name="m")
        c.addObject("CableConstraint", name="cable", indices=list(range(len(line))), pullPoint=pull, valueType="force", value=[0.],
                    minForce=0, maxForce=1e3)
        c.addObject("BarycentricMapping")
        return c


def createScene(root):
    root.addObject("FreeMotionAnimationLoop", parallelCollisionDetectionAndFreeMotion=True, parallelODESolving=False)
    root.addObject("ProjectedGaussSeidelConstraintSolver", tolerance=1e-8, maxIterations=2000)
    root.addObject("VisualStyle", displayFlags=["showBehavior", "showForceFields"])
    c = Robot(root, mu=900).build().cable("top", [[x, 18, 10] for x in (10, 40, 75)], [0, 18, 10])

    class Ramp(Sofa.Core.Controller):
        def onAnimateBeginEvent(self, e):
            c.cable.value = [min(c.cable.value[0] + 5., 30.)]
    root.addObject(Ramp(name="ramp"))
    return root
