# SPDX-License-Identifier: LGPL-2.1-or-later
"""SOFA's CarvingManager: at the end of a step in which it is `active`, parts of surfaces that a tool has come near go, with the cells
that they are faces of. The tool is a collision model with the tag CarvingTool or that of `toolModel`, the surfaces have the tag
CarvingSurface. Near: contacts whose gap, the distance less the contact distance, is below `carvingDistance`."""
from . import _cells, _messages
from ._base import Base
from ._objects import Object


class CarvingManager(Object):
    """An object of Python: the engine has CarvingRegion, whose shape is its own."""

    def _s_models(self, word, link):
        """Collision models that `link` leads to, else those of the scene with the tag."""
        data = self._s_data.get(link)
        if data is not None and data._s_raw not in (None, ""):
            found = data.getLinkedBase()
            return [found] if isinstance(found, Object) else []
        return [each for each in self.getRoot()._s_all_objects()
                if each._s_type and each._s_facts.role == "collision model" and each.hasTag(word)]

    def _s_is_active(self):
        return self.findData("active").value

    def _s_read(self, data):
        return Base._s_read(self, data)

    def _s_write(self, data, value):
        """Nothing of it is in the engine, whose scene stays what it is."""
        if data._s_name == "name":
            return self.setName(value)
        data._s_raw = value
        return None

    def _s_hears_key(self, key, pressed):
        """`key` while it is held, `keySwitch` in turns."""
        held, turns = (str(self.findData(name).value) for name in ("key", "keySwitch"))
        if key == held:
            self.active = pressed
        elif key == turns and pressed:
            self.active = not self._s_is_active()

    def _s_carve(self, engine):
        tools, surfaces = self._s_models("CarvingTool", "toolModel"), self._s_models("CarvingSurface", "surfaceModelPath")
        response = engine.contact_response()
        if not tools or not surfaces or response is None:
            what = "tool: a collision model with the tag CarvingTool, or toolModel" if not tools else \
                "surface: collision models with the tag CarvingSurface" if not surfaces else "CollisionResponse that acts"
            return _messages.warn(f"{self._s_place()}: carves nothing: the scene has no {what}")
        numbers = {path: number for number, path in enumerate(response.get("models"))}
        tool = numbers.get(engine.mirror.paths.get(id(tools[0])))
        near = self.findData("carvingDistance").value
        pairs, gaps = response.get("pairs").tolist(), response.get("gaps")
        for surface in surfaces:
            number = numbers.get(engine.mirror.paths.get(id(surface)))
            parts = {other if first == tool else part for (first, part, second, other), gap in zip(pairs, gaps)
                     if gap < near and {first, second} == {tool, number}}
            if parts and number is not None:
                self._s_take_away(surface, sorted(parts))
        return None

    def _s_take_away(self, surface, parts):
        """Of a surface of triangles: the cells of the mesh that it is made of, or its own."""
        if surface._s_type != "TriangleCollisionModel":
            return _messages.warn(f"{self._s_place()}: a {surface._s_type} is not carved: surfaces of triangles are")
        node = surface._s_node()
        container = _container_of(node)
        if container is None:
            return _messages.warn(f"{self._s_place()}: {surface.getPathName()} has no mesh of triangles that a modifier could change")
        rows = _cells.cells(container, "triangles")
        faces = [frozenset(rows[part].tolist()) for part in parts if part < len(rows)]
        body = _source_of(node, container)
        if body is None:
            return _modifier_of(node).removeTriangles(parts)
        cells = _cells.cells(body, "tetrahedra").tolist()
        gone = [number for number, cell in enumerate(cells) if any(face <= set(cell) for face in faces)]
        return _modifier_of(body._s_node()).removeTetrahedra(gone) if gone else None


def _container_of(node):
    return next((each for each in reversed(node._s_objects) if each._s_type == "TriangleSetTopologyContainer"), None)


def _source_of(node, container):
    """The container of tetrahedra whose surface it is, or None."""
    for each in node._s_objects:
        if each._s_type == "Tetra2TriangleTopologicalMapping":
            return each.findData("input").getLinkedBase()
    return None


def _modifier_of(node):
    from ._modifier import Modifier

    found = next((each for each in node._s_objects if isinstance(each, Modifier)), None)
    if found is None:
        raise RuntimeError(f"{node._s_place()}: has no modifier of its mesh, which a CarvingManager is to change")
    return found


def managers(root):
    return [each for each in root._s_all_objects() if isinstance(each, CarvingManager)]


def carve(engine):
    """The end of a step."""
    for each in managers(engine.root) if engine.has_carving else ():
        if each._s_is_active():
            each._s_carve(engine)


def hear_key(root, key, pressed):
    for each in managers(root):
        each._s_hears_key(key, pressed)
