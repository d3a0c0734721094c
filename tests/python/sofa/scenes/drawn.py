# SPDX-License-Identifier: LGPL-2.1-or-later
"""Cameras, lights, grids, colours, text: what only draws is taken, and may be read and moved."""
import Sofa
from Sofa.Types import RGBAColor


class Orbit(Sofa.Core.Controller):
    def __init__(self, camera, light):
        Sofa.Core.Controller.__init__(self)
        self.camera, self.light = camera, light

    def onAnimateBeginEvent(self, event):
        with self.camera.position.writeableArray() as wa:
            wa[0] += 0.1
        self.camera.lookAt = [0, 0, 0]
        self.light.color.value = [1, 1, 1]


def createScene(root):
    root.bbox = [[-1, -1, -1], [1, 1, 1]]
    root.addObject('VisualStyle', displayFlags=['showVisualModels', 'showBehaviorModels'])
    root.addObject('BackgroundSetting', color=[1, 1, 1, 1], image="")
    root.addObject('OglSceneFrame', style="Arrows", alignment="TopRight")
    root.addObject('OglGrid', nbSubdiv=10, size=1000)
    root.addObject('LightManager', listening=True, ambient=(1, 1, 1, 1))
    light = root.addObject('DirectionalLight', name='sun', direction=[0, 1, 0])
    root.addObject('SpotLight', name='spotLight1', position=[0, 40, 60], direction=[0, -1, -1], cutoff=180, exponent=1)
    camera = root.addObject('InteractiveCamera', name='camera', position=[0, 30, 90], lookAt=[0, 30, 0], zNear=5, zFar=500, fieldOfView=60)
    root.addObject('ClipPlane', position=[0, 0, 0], normal=[1, 0, 0])
    root.addObject('DefaultVisualManagerLoop')
    root.addObject('DefaultAnimationLoop')
    root.addObject('OglLabel', label='Hello', x=20, y=20, fontsize=14, selectContrastingColor=True)
    ball = root.addChild('ball')
    ball.addObject('EulerImplicitSolver')
    ball.addObject('CGLinearSolver', iterations=25, tolerance=1e-9, threshold=1e-9)
    ball.addObject('MechanicalObject', template='Rigid3', name='mstate', position=[0, 0, 0, 0, 0, 0, 1], showObject=True)
    ball.addObject('UniformMass', totalMass=1)
    visual = ball.addChild('VisualModel')
    visual.loader = visual.addObject('MeshOBJLoader', name='loader', filename='mesh/cube.obj')
    visual.addObject('OglModel', name='model', src='@loader', scale3d=[50] * 3, color=RGBAColor(0., 1., 0., 1.), updateNormals=False,
                     material='Default Diffuse 1 1 0 0 1')
    visual.addObject('RigidMapping')
    root.addObject(Orbit(camera, light))
