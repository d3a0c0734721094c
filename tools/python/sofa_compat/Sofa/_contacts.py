# SPDX-License-Identifier: LGPL-2.1-or-later
"""Contacts as scenes read them: of two surfaces, and as rows of a constraint solver."""
import numpy as np

from . import _messages
from ._objects import Object


def turned_round(component, types):
    """Which contacts of a CollisionResponse SOFA has the other way round: a triangle is first before a line, and both before points and
    spheres, whatever the order of the scene. types: of the collision models, by their path."""
    corners = [next((n for word, n in (("Triangle", 3), ("Line", 2)) if types.get(path, "").startswith(word)), 1)
               for path in component.get("models")]
    return np.array([corners[a] < corners[b] for a, _, b, _ in component.get("pairs").tolist()], bool)


def rows_of(component, types):
    """Forces of the contacts of a CollisionResponse with friction, as SOFA orders them: along the normal and two tangents of each,
    or along the normal alone where there is no friction."""
    sign = np.where(turned_round(component, types), -1.0, 1.0)[:, None]
    forces, normals = sign * component.get("forces"), sign * component.get("normals")
    if len(component.get("multipliers")) == len(normals):
        return np.einsum("ij,ij->i", forces, normals)
    return np.einsum("ikj,ij->ik", np.stack([normals, *tangents(normals)], axis=1), forces).ravel()


def tangents(normals):
    """Of SOFA: across a normal and the same with its components turned round; any where both are one."""
    across = np.cross(normals, np.roll(normals, 1, axis=1))
    length = np.linalg.norm(across, axis=1, keepdims=True)
    diagonal = np.cross(normals, [1.0, 0, 0])
    second = np.where(length > 1e-9, across, diagonal)
    second = second / np.linalg.norm(second, axis=1, keepdims=True) if len(second) else second
    return np.cross(second, normals), second


def _in_order(number, first, second, other_way):
    """number: of the model that `first` is on."""
    return (1 - number, second, number, first) if other_way else (number, first, 1 - number, second)


class ContactListener(Object):
    """The contacts of two collision models, of where the last step started. Models are 0 and 1 in what it answers."""

    def _s_model(self, name):
        data = self.findData(name)
        if data is None or data._s_raw is None or data._s_raw == "":
            node = self._s_node()
            while node is not None:
                for each in node._s_objects:
                    if each._s_type and each._s_facts.role == "collision model":
                        return each
                node = node._s_above()
            raise RuntimeError(f"{self._s_place()}: has no {name}, and there is no collision model in this node or above")
        model = data.getLinkedBase()
        if not isinstance(model, Object) or not model._s_type or model._s_facts.role != "collision model":
            found = "nothing" if model is None else f"{model.getPathName()}, which is no collision model"
            raise RuntimeError(f"{self._s_place()}: {name} leads to {found}")
        return model

    def _s_contacts(self):
        """(whether the first surface is collisionModel2, entry of the response, whether SOFA has its second one first) of each, and the
        response."""
        engine, models = self._s_engine(), [self._s_model(name) for name in ("collisionModel1", "collisionModel2")]
        response = engine.contact_response() if engine is not None else None
        if response is None:
            if engine is not None:
                _messages.warn(f"{self._s_place()}: the scene has no CollisionResponse that acts, and so no contacts")
            return [], None
        numbers = {path: number for number, path in enumerate(response.get("models"))}
        first, second = (numbers.get(engine.mirror.paths.get(id(each))) for each in models)
        found, other_way = [], turned_round(response, engine.types())
        for entry, (a, _, b, _) in enumerate(response.get("pairs").tolist()):
            if (a, b) in ((first, second), (second, first)):
                found.append((int(a != first), entry, other_way[entry]))
        return found, response

    def getNumberOfContacts(self):
        return len(self._s_contacts()[0])

    def getDistances(self):
        """How much farther apart than their contact distance."""
        found, response = self._s_contacts()
        gaps = response.get("gaps") if found else ()
        return [float(gaps[entry]) for _, entry, _ in found]

    def getContactPoints(self):
        """(model, point, model, point) of each."""
        found, response = self._s_contacts()
        first, second = (response.get(name) if found else () for name in ("firstPoints", "secondPoints"))
        return [_in_order(number, first[entry].tolist(), second[entry].tolist(), other) for number, entry, other in found]

    def getContactElements(self):
        """(model, number of its point, line, triangle or sphere, model, number) of each."""
        found, response = self._s_contacts()
        pairs = response.get("pairs").tolist() if found else ()
        return [_in_order(number, pairs[entry][1], pairs[entry][3], other) for number, entry, other in found]

    def getContactData(self):
        """The same by the names numberOfContacts, collisionPointsModel1, ... collisionElementsModel2."""
        data = {"numberOfContacts": self.getNumberOfContacts()}
        for word, found in (("Points", self.getContactPoints()), ("Elements", self.getContactElements())):
            for model in (0, 1):
                data[f"collision{word}Model{model + 1}"] = [each[1] if each[0] == model else each[3] for each in found]
        return data
