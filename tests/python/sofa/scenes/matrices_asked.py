# SPDX-License-Identifier: LGPL-2.1-or-later
"""K and M of components, and what a linear system and a constraint solver would tell, asked for by attributes that may not be there."""
import numpy as np
import Sofa
from scipy import sparse
from scipy.sparse import linalg


class Modes(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.force_field, self.mass = kwargs.get("force_field"), kwargs.get("mass")
        self.linear_solver = kwargs.get("linear_solver")

    def onAnimateEndEvent(self, event):
        K = self.force_field.assembleKMatrix()
        M = self.mass.assembleMMatrix()
        assert sparse.issparse(K) and K.shape == M.shape and K.dtype == np.float64
        A = (M - 0.01 ** 2 * K).tocsc()
        x = linalg.spsolve(A, np.ones(A.shape[0]))
        assert np.isfinite(x).all()
        for call in ("A", "b", "x"):
            found = getattr(self.linear_solver, call, None)
            if found is not None and callable(found):
                try:
                    found()
                except AttributeError as error:
                    print(error)
        np.set_printoptions(precision=3)
        print(K.toarray()[:3, :3])


def createScene(root):
    root.dt = 0.01
    root.bbox = [[-1, -1, -1], [1, 1, 1]]
    root.addObject("DefaultAnimationLoop")
    root.addObject("VisualStyle", displayFlags=["showBehaviorModels", "showForceFields"])
    n = root.addChild("FEM")
    n.addObject("EulerImplicitSolver", rayleighStiffness=0.1, rayleighMass=0.1)
    solver = n.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixd", applyPermutation="false")
    n.addObject("MechanicalObject", name="mo", position="0 0 0  1 0 0  0 1 0  0 0 1")
    n.addObject("MeshTopology", name="topo", hexahedra=[], tetrahedra=[[0, 1, 2, 3]])
    mass = n.addObject("UniformMass", totalMass=320)
    ff = n.addObject("TetrahedronFEMForceField", name="ff", youngModulus=1000, poissonRatio=0.3, method="small")
    n.addObject(Modes(name="Modes", force_field=ff, mass=mass, linear_solver=solver))
