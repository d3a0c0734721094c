# SPDX-License-Identifier: LGPL-2.1-or-later
"""A force field of the scene with its matrix as rows of (row, column, value)."""
import numpy as np
import Sofa


class RestShapeForceField(Sofa.Core.ForceFieldVec3d):
    def __init__(self, ks=1.0, kd=1.0, *args, **kwargs):
        Sofa.Core.ForceFieldVec3d.__init__(self, *args, **kwargs)
        self.addData("ks", type="double", value=ks, help="stiffness", group="Spring's properties")
        self.addData("kd", type="double", value=kd, help="damping", group="Spring's properties")

    def init(self):
        mstate = self.mstate
        self.initpos = mstate.position.array().copy()
        self.k = np.zeros((1, 1))
        self.f = []
        if self.ks.value == 0:
            Sofa.msg_error(self, "the stiffness is zero")

    def addForce(self, m, out_force, pos, vel):
        with out_force.writeableArray() as wa:
            wa[:] += (self.initpos - pos.value) * self.ks.value

    def addDForce(self, df, dx, params, bFactor):
        pass

    def addKToMatrix(self, a, b):
        pass

    def addKToMatrix(self, mparams, nNodes, nDofs):  # noqa: F811
        K = []
        for i in range(nNodes * nDofs):
            K.append([i, i, -self.ks.value * mparams['kFactor']])
        return np.array(K)


def createObject(rootNode, name, py_forcefield=None):
    obj = rootNode.addChild(name)
    obj.addObject('EulerImplicitSolver', rayleighStiffness=0.1, rayleighMass=0.1)
    obj.addObject('SparseLDLSolver', name='direct', template='CompressedRowSparseMatrixMat3x3d')
    obj.addObject('MechanicalObject', name="MO", position=[[0, 0, 0], [1, 0, 0]])
    obj.addObject('UniformMass', name="mass", totalMass=2)
    obj.addObject(py_forcefield)
    return obj


def createScene(node):
    node.addObject('DefaultAnimationLoop')
    node.addObject("RequiredPlugin", name="Sofa.Component.Mass")
    node.dt = 0.02
    node.gravity = [0, -9.81, 0]
    createObject(node, "py_implicit", py_forcefield=RestShapeForceField(name="CPPObject", ks=20.0, kd=5.0))
