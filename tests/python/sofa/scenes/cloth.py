# SPDX-License-Identifier: LGPL-2.1-or-later
"""A sheet of triangles from a grid, with quads that become triangles, springs and wind."""
import Sofa


def createScene(root):
    root.gravity = [0, -9.81, 0]
    root.dt = 0.01
    root.addObject('RequiredPlugin', pluginName=['Sofa.Component.Topology.Container.Grid', 'Sofa.Component.SolidMechanics.Spring'])
    root.addObject('DefaultAnimationLoop')
    cloth = root.addChild('cloth')
    cloth.addObject('EulerImplicitSolver', rayleighMass=0.01, rayleighStiffness=0.01)
    cloth.addObject('CGLinearSolver', iterations=40, tolerance=1e-8, threshold=1e-10)
    cloth.addObject('RegularGridTopology', name='grid', nx=6, ny=1, nz=6, xmin=0, xmax=1, ymin=0, ymax=0, zmin=0, zmax=1)
    cloth.addObject('MechanicalObject', name='dofs', template='Vec3')
    cloth.addObject('UniformMass', totalMass=0.2)
    cloth.addObject('MeshSpringForceField', linesStiffness=100, linesDamping=0.1, quadsStiffness=50)
    cloth.addObject('FixedProjectiveConstraint', indices=[0, 5])
    cloth.addObject('ConstantForceField', forces=[[0, 0, 0.01]], indices=list(range(6, 36)))
    tri = cloth.addChild('triangles')
    tri.addObject('TriangleSetTopologyContainer', name='container')
    tri.addObject('TriangleSetTopologyModifier')
    tri.addObject('Quad2TriangleTopologicalMapping', input='@../grid', output='@container')
    tri.addObject('TriangularFEMForceField', youngModulus=1000, poissonRatio=0.3, method='large')
