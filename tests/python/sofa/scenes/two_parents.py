# SPDX-License-Identifier: LGPL-2.1-or-later
"""A node with two parents, as scenes make that couple two bodies: it is one node, at its first parent."""


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    root.gravity = [0, 0, -10]
    root.dt = 0.1
    root.addObject("EulerImplicitSolver")
    root.addObject("CGLinearSolver", iterations=20, tolerance=1e-14, threshold=1e-14)
    one, two = root.addChild("one"), root.addChild("two")
    for node, x in ((one, 0), (two, 1)):
        node.addObject("MechanicalObject", name="dofs", position=[x, 0, 0])
        node.addObject("UniformMass", totalMass=1)
    both = one.addChild("both")
    two.addChild(both)
    both.addObject("MechanicalObject", name="points", position=[[0, 0, 0], [1, 0, 0]])
    both.addObject("SubsetMultiMapping", input=["@/one/dofs", "@/two/dofs"], output="@./", indexPairs="0 0 1 0")
    assert len(both.parents) == 2 and both.getPathName() == "/one/both"
