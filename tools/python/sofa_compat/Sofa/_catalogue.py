# SPDX-License-Identifier: LGPL-2.1-or-later
"""What is known of types of components: Stroma's tables, and data of SOFA that scenes read though nothing here has them."""
import functools
import threading

import numpy as np
import stroma
from stroma import _stroma

#: roles whose values are computed by their init() and may be read before there is a simulation
COMPUTED_ROLES = {"mesh loader", "topology", "selection", "engine", "mesh engine", "mechanical state", "topological mapping", "mapping"}

_POINTS = np.zeros((0, 3))

#: data of SOFA's components that have no effect here and may be read
_BESIDES = {
    "MechanicalObject": {
        "force": _POINTS, "free_position": _POINTS, "free_velocity": _POINTS, "externalForce": _POINTS, "derivX": _POINTS,
        "lambda": _POINTS, "reset_position": _POINTS, "reset_velocity": _POINTS, "constraint": "",
        "showObject": False, "showObjectScale": 0.1,
        "showIndices": False, "showIndicesScale": 0.02, "showVectors": False, "showVectorsScale": 0.0001, "drawMode": 0,
        "showColor": "1 1 1 1", "showIndicesSize": 0.02, "size": 0, "reserve": 0,
    },
    "VisualStyle": {"displayFlags": ""},
    "OglModel": {
        "position": _POINTS, "restPositions": _POINTS, "vertices": _POINTS, "normal": _POINTS, "texturename": "",
        "translation": np.zeros(3), "rotation": np.zeros(3), "scale3d": np.ones(3), "updateNormals": True, "filename": "", "src": "",
        "triangles": np.zeros((0, 3), np.int32), "quads": np.zeros((0, 4), np.int32), "edges": np.zeros((0, 2), np.int32),
    },
    "Camera": {"position": np.zeros(3), "lookAt": np.zeros(3), "orientation": np.array([0.0, 0, 0, 1]), "distance": 0.0, "zNear": 0.0,
               "zFar": 0.0, "fieldOfView": 45.0},
    "CarvingManager": {"active": False, "carvingDistance": 0.0, "toolModel": "", "surfaceModelPath": "", "narrowPhaseDetection": "",
                       "key": "1", "keySwitch": "4", "mouseEvent": True, "omniEvent": True, "activatorName": "button1"},
    "BackgroundSetting": {"image": ""},
    "RequiredPlugin": {"pluginName": ""},
}
for _each in ("TetrahedronFEMForceField", "HexahedronFEMForceField", "TetrahedralCorotationalFEMForceField"):
    _BESIDES[_each] = {"vonMisesPerElement": np.zeros(0), "vonMisesPerNode": np.zeros(0)}
for _each in ("VisualModel", "OglCylinderModel", "VisualModelImpl"):
    _BESIDES[_each] = _BESIDES["OglModel"]
DRAWN = _BESIDES["OglModel"]
for _each in ("InteractiveCamera", "RecordedCamera", "BaseCamera"):
    _BESIDES[_each] = _BESIDES["Camera"]
CONSTRAINTS = {"computeConstraintForces": False, "constraintForces": np.zeros(0), "maxIterations": 1000, "tolerance": 0.001,
                "currentNumConstraints": 0, "currentNumConstraintGroups": 0, "currentIterations": 0, "currentError": 0.0,
                "reverseAccumulateOrder": False}
#: of those, what a step leaves there
OF_CONSTRAINTS = {"constraintForces", "currentNumConstraints", "currentIterations", "currentError"}
for _each in ("GenericConstraintSolver", "LCPConstraintSolver", "BlockGaussSeidelConstraintSolver",
              "ProjectedGaussSeidelConstraintSolver", "NNCGConstraintSolver", "UnbuiltGaussSeidelConstraintSolver"):
    _BESIDES[_each] = CONSTRAINTS

#: types that Python plays, and the engine does not have
OF_PYTHON = {"CarvingManager"}

#: of those, what SOFA computes in each step
NOT_COMPUTED = {"currentNumConstraintGroups", "vonMisesPerElement", "vonMisesPerNode", "constraint", "derivX", "externalForce"}

#: lists of numbers that SOFA keeps in rows; of a name in place of a number: as many as velocities or positions of the template have
_ROWS = {("ConstantForceField", "forces"): "velocity", ("BoxROI", "box"): 6, ("BoxROI", "orientedBox"): 10, ("PlaneROI", "plane"): 10,
         ("LinearForceField", "forces"): "velocity", ("LinearVelocityProjectiveConstraint", "velocities"): "velocity",
         ("RigidRigidMapping", "initialPoints"): 7,
         **{("MergePoints", name): "position" for name in ("position1", "position2", "points")}}
#: lists of cells that SOFA's topologies have, whatever they are made of
_CELLS = {"edges": 2, "triangles": 3, "quads": 4, "tetrahedra": 4, "hexahedra": 8}
#: engines whose lists hold values of their template
_OF_TEMPLATE = {"ValuesFromIndices", "IndicesFromValues", "MergeVectors", "DifferenceEngine", "MathOp"}


class Facts:
    """One type: `info` of Stroma's table, or None; whether it is accepted without effect, or not there at all."""

    def __init__(self, word):
        self.word = word
        present = _sofa_type(stroma.present_type(word))
        self.info = _quietly(stroma.type_info, present)
        self.accepted = self.info is None and (stroma.has_no_effect(word) or _sofa_accepts(word) or _sofa_accepts(present))
        self.written = present if self.accepted and _sofa_accepts(present) else word  # ParallelBVHNarrowPhase: BVHNarrowPhase
        self.besides = _BESIDES.get(word) or _BESIDES.get(present) or {}
        self._attributes = {}
        for each in self.info.attributes if self.info else []:
            for name in [each.name, *each.aliases]:
                self._attributes.setdefault(name, each)

    @property
    def missing(self):
        return self.info is None and not self.accepted and self.word not in OF_PYTHON

    @property
    def role(self):
        return self.info.role if self.info else ""

    def find(self, name):
        return self._attributes.get(name)

    def names(self):
        return list(self._attributes) + list(self.besides)

    def sample(self, name, template):
        """A value of the attribute's kind: its default, in the columns that the template asks for. None: there is no such data."""
        from . import _values

        found = self._attributes.get(name)
        if found is None:
            if name in self.besides:
                return self.besides[name]
            if name in _CELLS and self.role == "topology":
                return np.zeros((0, _CELLS[name]), np.int32)
            if name == "nbPoints" and self.role == "topology":
                return 0
            shown = self.info is not None and not name.startswith("_") and _stroma.is_accepted(self.word, name)
            return "" if shown else None
        if found.link:
            return ""
        if self.info.role == "mechanical state" and name in ("position", "rest_position", "velocity"):
            table = _values.VELOCITIES if name == "velocity" else _values.COORDINATES
            return np.zeros((0, table.get(_values.plain_template(template), 3)))
        rows = _ROWS.get((self.info.type, found.name))
        if self.info.type in _OF_TEMPLATE and isinstance(found.value, np.ndarray) and found.value.dtype.kind == "f":
            rows = _values.columns_of(template)
        if rows is not None and isinstance(found.value, np.ndarray) and found.value.ndim == 1 and not found.value.size:
            tables = {"velocity": _values.VELOCITIES, "position": _values.COORDINATES}
            columns = tables[rows].get(_values.plain_template(template), 3) if rows in tables else rows
            return np.zeros((0, columns))
        return found.value


def _sofa_type(word):
    """The present name, in SOFA's dialect."""
    return _stroma.sofa_type(word)


def _sofa_accepts(word):
    """Whether SOFA's dialect takes the type without effect."""
    return _stroma.sofa_accepts(word)


def _quietly(function, *arguments):
    try:
        return function(*arguments)
    except RuntimeError:  # a module that does not open is reported when the scene is loaded
        return None


_making = threading.RLock()


@functools.lru_cache(maxsize=None)
def _made(word):
    return Facts(word)


def facts(word):
    """One thread at a time: the cache does not wait, and a type asked for while another thread opens its module may seem not to exist."""
    with _making:
        return _made(word)
