# SPDX-License-Identifier: LGPL-2.1-or-later
"""Prefabs that hold prefabs; parameters as links; a prefab with __init__ of its own; one that is used twice with other names."""
import Sofa
import Sofa.Core


class VisualModel(Sofa.Prefab):
    prefabParameters = [
        {'name': 'visualMeshPath', 'type': 'string', 'help': 'Path to visual mesh file', 'default': 'mesh/cube.obj'},
        {'name': 'translation', 'type': 'Vec3d', 'help': 'translate visual model', 'default': [0.0, 0.0, 0.0]},
        {'name': 'rotation', 'type': 'Vec3d', 'help': 'rotate visual model', 'default': [0.0, 0.0, 0.0]},
        {'name': 'scale', 'type': 'Vec3d', 'help': 'scale visual model', 'default': [1.0, 1.0, 1.0]},
        {'name': 'color', 'type': 'Vec4d', 'help': 'color visual model', 'default': [1., 1., 1., 1.]}]

    def __init__(self, *args, **kwargs):
        Sofa.Prefab.__init__(self, *args, **kwargs)

    def init(self):
        self.addObject('MeshOBJLoader', name='loader', filename=self.visualMeshPath.value)
        self.addObject('OglModel', name="OglModel", src="@loader", rotation=list(self.rotation.value),
                       translation=list(self.translation.value), scale3d=list(self.scale.value), color=list(self.color.value),
                       updateNormals=False)


class Cube(Sofa.Prefab):
    prefabParameters = [
        {'name': 'rotation', 'type': 'Vec3d', 'help': 'Rotation', 'default': [0.0, 0.0, 0.0]},
        {'name': 'translation', 'type': 'Vec3d', 'help': 'Translation', 'default': [0.0, 0.0, 0.0]},
        {'name': 'uniformScale', 'type': 'double', 'help': 'scale', 'default': 1.0},
        {'name': 'totalMass', 'type': 'double', 'help': '', 'default': 1.0},
        {'name': 'isAStaticObject', 'type': 'bool', 'help': '', 'default': False}]

    def __init__(self, *args, **kwargs):
        Sofa.Prefab.__init__(self, *args, **kwargs)

    def init(self):
        self.addObject('MechanicalObject', name="mstate", template="Rigid3", translation2=list(self.translation.value),
                       rotation2=list(self.rotation.value), showObjectScale=self.uniformScale.value)
        if not self.isAStaticObject.value:
            self.addObject('EulerImplicitSolver')
            self.addObject('CGLinearSolver', iterations=25, tolerance=1e-12, threshold=1e-12)
            self.addObject('UniformMass', name="mass", totalMass=self.totalMass.value)
        visual = VisualModel(name="VisualModel", visualMeshPath="mesh/cube.obj", color=[1., 1., 0., 1.],
                             scale=[self.uniformScale.value] * 3)
        self.addChild(visual)
        visual.addObject('RigidMapping')


class Scene(Sofa.Prefab):
    """ Docstring of a prefab """
    prefabParameters = []

    def init(self):
        for i in range(2):
            self.addChild(Cube(name="Cube_%d" % i, translation=[0., 10. * i, 0.], totalMass=0.2 + i))
        self.Cube_0.mass.totalMass.value = 0.3


def createScene(rootNode):
    rootNode.addObject('DefaultAnimationLoop')
    rootNode.dt = 0.01
    scene = Scene(name="Scene")
    rootNode.addChild(scene)
    floor = rootNode.addChild(Cube(name="Floor", isAStaticObject=True, translation=[0.0, -5.0, 0.0]))
    assert floor is rootNode.Floor and rootNode.Scene.Cube_1.translation.value[1] == 10
    print(scene.getData("docstring").value, rootNode.Scene.Cube_0.mstate.getLinkPath(), rootNode.Scene.Cube_1.mass.getPathName())
