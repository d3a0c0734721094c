# SPDX-License-Identifier: LGPL-2.1-or-later
"""Particles and springs between nodes, with functions that make parts and numbers as texts."""
import Sofa
import math


def particle(node, name, position, fixed=False):
    child = node.addChild(name)
    child.createObject('MechanicalObject', name='dofs', position=' '.join(str(c) for c in position), template='Vec3d') \
        if hasattr(child, 'createObject') else None
    child.addObject('UniformMass', totalMass='0.5')
    if fixed:
        child.addObject('FixedConstraint', indices='0')
    return child


def createScene(rootNode):
    rootNode.findData('gravity').value = '0 -10 0'
    rootNode.findData('dt').value = '0.02'
    rootNode.addObject('DefaultAnimationLoop')
    rootNode.addObject('EulerImplicitSolver', name='cg', printLog='false')
    rootNode.addObject('CGLinearSolver', iterations='25', tolerance='1e-9', threshold='1e-9')
    chain = [particle(rootNode, f'P{i}', (math.cos(i), -i, 0), i == 0) for i in range(5)]
    for a, b in zip(chain, chain[1:]):
        rootNode.addObject('StiffSpringForceField', name=f'spring_{a.name.value}', object1=a.dofs.getLinkPath(),
                           object2='@' + b.getPathName() + '/dofs', spring=[0, 0, 100., 1., 1.])
    assert rootNode.getChild('P2').getObject('dofs').findData('position').value.shape == (1, 3)
