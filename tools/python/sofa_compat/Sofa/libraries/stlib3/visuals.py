# SPDX-License-Identifier: LGPL-2.1-or-later
"""What is drawn."""
import Sofa
import Sofa.Core
from Sofa import _libraries

_libraries.same_module(__name__, "visualmodel", "VisualModel")
_LOADERS = {".stl": "MeshSTLLoader", ".obj": "MeshOBJLoader"}


def ShowGrid(node):
    node.addObject("OglGrid", nbSubdiv=10, size=1000)


class VisualModel(Sofa.Prefab):
    """A surface of a file; visual.addObject("BarycentricMapping") lets it follow a body."""

    properties = [
        {"name": "visualMeshPath", "type": "string", "help": "file", "default": ""},
        {"name": "translation", "type": "Vec3d", "help": "", "default": [0., 0., 0.]},
        {"name": "rotation", "type": "Vec3d", "help": "degrees", "default": [0., 0., 0.]},
        {"name": "scale", "type": "Vec3d", "help": "", "default": [1., 1., 1.]},
        {"name": "color", "type": "Vec4d", "help": "", "default": [1., 1., 1., 1.]}]

    def __init__(self, *args, **kwargs):
        if "surfaceMeshFileName" in kwargs:  # its name in Python 2
            kwargs["visualMeshPath"] = kwargs.pop("surfaceMeshFileName")
        Sofa.Prefab.__init__(self, *args, **kwargs)

    @property
    def node(self):
        return self

    def init(self):
        path = self.visualMeshPath.value
        if path[-4:] in _LOADERS:
            self.addObject(_LOADERS[path[-4:]], name="loader", filename=path)
        else:
            Sofa.msg_error(self, f"'{path}' is no .stl and no .obj")
        self.addObject("OglModel", name="OglModel", src="@loader", rotation=list(self.rotation.value),
                       translation=list(self.translation.value), scale3d=list(self.scale.value), color=self.color.value,
                       updateNormals=False)

    def showGrid(self, nbSubdiv=10, size=1000):
        self.addObject("OglGrid", nbSubdiv=nbSubdiv, size=size)
