# SPDX-License-Identifier: LGPL-2.1-or-later
"""Folders of files that a scene adds, and tables of SOFA's runtime."""
import os

import Sofa
import SofaRuntime

SofaRuntime.importPlugin("SofaComponentAll")
SofaRuntime.importPlugin("Sofa.Component.StateContainer")
SofaRuntime.PluginRepository.addFirstPath(os.environ.get("SOFA_ROOT", "/nowhere"))
SofaRuntime.DataRepository.addFirstPath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "mesh"))


def createScene(rootNode):
    SofaRuntime.Timer.setEnabled("Animate", True)
    rootNode.addObject("DefaultAnimationLoop", computeBoundingBox=False)
    rootNode.addObject("AddResourceRepository", path=os.path.dirname(__file__))
    body = rootNode.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=30, tolerance=1e-9, threshold=1e-9)
    body.addObject("MeshVTKLoader", name="loader", filename="finger.vtk")
    body.addObject("MeshTopology", src=body.loader.getLinkPath())
    body.addObject("MechanicalObject", name="dofs")
    body.addObject("UniformMass", totalMass=1.0)
    body.addObject("TetrahedronFEMForceField", youngModulus=[1e4], poissonRatio=[0.3])
    print(SofaRuntime.getCategories("MechanicalObject"), SofaRuntime.DataRepository.getFile("finger.vtk"))
