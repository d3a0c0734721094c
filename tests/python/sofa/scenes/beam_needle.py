# SPDX-License-Identifier: LGPL-2.1-or-later
"""A needle of beams with frames, a collision line that a mapping moves, and a base that a controller drives."""
import numpy as np
import Sofa


class Insert(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.MO = kwargs["MO"]

    def onAnimateBeginEvent(self, event):
        with self.MO.position.writeable() as pos:
            pos[0][0] += 0.01


def createScene(root):
    root.gravity = [0, 0, 0]
    root.addObject('DefaultAnimationLoop')
    needle = root.addChild('needle')
    needle.addObject('EulerImplicitSolver', rayleighStiffness=0.1, rayleighMass=0.1)
    needle.addObject('SparseLDLSolver', template='CompressedRowSparseMatrixd')
    count = 6
    needle.addObject('MechanicalObject', template='Rigid3d', name='dofs', position=[[i * 0.5, 0, 0, 0, 0, 0, 1] for i in range(count)])
    needle.addObject('MeshTopology', name='lines', lines=np.array([[i, i + 1] for i in range(count - 1)]))
    needle.addObject('BeamFEMForceField', name='FEM', radius='0.05', youngModulus=1e5, poissonRatio='0.3')
    needle.addObject('UniformMass', totalMass=0.1)
    needle.addObject('RestShapeSpringsForceField', name='spring', stiffness=1e8, angularStiffness=1e8, external_rest_shape='@../base/dofs',
                     points=0, external_points=0)
    collision = needle.addChild('collision')
    collision.addObject('MechanicalObject', name='points', position=[[i * 0.5, 0, 0] for i in range(count)])
    collision.addObject('RigidMapping', rigidIndexPerPoint=list(range(count)), globalToLocalCoords=True)
    base = root.addChild('base')
    MO = base.addObject('MechanicalObject', template='Rigid3d', name='dofs', position='0 0 0 0 0 0 1', showObject='1')
    root.addObject(Insert(MO=MO))
