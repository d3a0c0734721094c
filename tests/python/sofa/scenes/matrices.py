# SPDX-License-Identifier: LGPL-2.1-or-later
"""Matrices that a controller asks for: of a force field, of a mass, of the system; where there is none it goes on."""
import Sofa
from Sofa import SofaLinearSystem  # noqa: F401


class MatrixAccessController(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.force_field = kwargs.get("force_field")
        self.mass = kwargs.get("mass")
        self.system = kwargs.get("system")
        self.found, self.missing = [], 0

    def onAnimateEndEvent(self, event):
        for ask in (lambda: self.force_field.assembleKMatrix(), lambda: self.mass.assembleMMatrix(), lambda: self.system.A(),
                    lambda: self.system.b()):
            try:
                self.found.append(ask())
                print('dtype:', self.found[-1].dtype, 'shape:', self.found[-1].shape)
            except AttributeError as error:
                self.missing += 1
                print(error)


def createScene(root):
    root.dt = 0.01
    root.addObject('DefaultAnimationLoop')
    child = root.addChild('FEM')
    child.addObject('EulerImplicitSolver', rayleighStiffness="0.1", rayleighMass="0.1")
    system = child.addObject('MatrixLinearSystem', template='CompressedRowSparseMatrixMat3x3d')
    child.addObject('SparseLDLSolver', template="CompressedRowSparseMatrixMat3x3d")
    child.addObject('RegularGridTopology', name="grid", min=[0, 0, 0], max=[3, 1, 1], n=[4, 2, 2])
    child.addObject('MechanicalObject', template='Vec3', name='DoFs')
    mass = child.addObject('MeshMatrixMass', totalMass=1.0, topology="@grid")
    fem = child.addObject('HexahedronFEMForceField', name="FEM", youngModulus=1000, poissonRatio=0.3, method="large")
    child.addObject('FixedProjectiveConstraint', indices=[0, 4, 8, 12])
    root.addObject(MatrixAccessController('MatrixAccessor', name='matrixAccessor', force_field=fem, mass=mass, system=system))
    return root
