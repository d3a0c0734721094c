# SPDX-License-Identifier: LGPL-2.1-or-later
"""Data engines: of SOFA, by links, and of the scene, with data of its own."""
import numpy as np
import Sofa


class MyEngine(Sofa.Core.DataEngine):
    def __init__(self, *args, **kwargs):
        Sofa.Core.DataEngine.__init__(self, *args, **kwargs)
        x = self.addData("x", value=1, type="int", help="input", group="inputs", default=1)
        out = self.addData("out", type="vector<Vec3d>", value=[[0, 0, 0]])
        self.addInput(x)
        self.addOutput(out)

    def init(self):
        self.update()

    def update(self):
        self.out.value = np.arange(3 * (1 + self.x.value)).reshape(-1, 3)


def createScene(root):
    root.gravity = [0, 0, 0]
    root.addObject('DefaultAnimationLoop')
    engine = root.addObject(MyEngine(name="engine", x=4))
    engine.x.value = 2
    points = root.addChild('points')
    points.addObject('EulerImplicitSolver')
    points.addObject('CGLinearSolver', iterations=10, tolerance=1e-9, threshold=1e-9)
    points.addObject('MechanicalObject', name='dofs', position=engine.out)
    points.addObject('UniformMass', totalMass=1.)
    points.addObject('TransformEngine', name='moved', input_position='@dofs.position', translation=[1, 0, 0], scale=[2, 2, 2])
    points.addObject('SphereROI', name='roi', centers=[0, 1, 2], radii=[0.5])
    other = points.addChild('other')
    other.addObject('MechanicalObject', name='copy', position='@../moved.output_position')
    assert len(points.roi.indices.value) == 1
    assert np.allclose(other.copy.position.value, 2 * np.arange(9).reshape(3, 3) + [1, 0, 0])
