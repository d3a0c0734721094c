# SPDX-License-Identifier: LGPL-2.1-or-later
"""What is drawn."""
import Sofa.Core


class VisualModel(Sofa.Prefab):
    properties = [
        {"name": "visualMeshPath", "type": "string", "help": "file", "default": ""},
        {"name": "translation", "type": "Vec3d", "help": "", "default": [0., 0., 0.]},
        {"name": "rotation", "type": "Vec3d", "help": "", "default": [0., 0., 0.]},
        {"name": "scale", "type": "Vec3d", "help": "", "default": [1., 1., 1.]},
        {"name": "color", "type": "Vec4d", "help": "", "default": [1., 1., 1., 1.]}]

    def init(self):
        path = self.visualMeshPath.value
        if path.endswith(".stl"):
            self.addObject("MeshSTLLoader", name="loader", filename=path)
        elif path.endswith(".obj"):
            self.addObject("MeshObjLoader", name="loader", filename=path)
        self.addObject("OglModel", name="OglModel", src="@loader", rotation=list(self.rotation.value),
                       translation=list(self.translation.value), scale3d=list(self.scale.value), color=self.color.value,
                       updateNormals=False)
