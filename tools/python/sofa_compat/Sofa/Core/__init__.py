# SPDX-License-Identifier: LGPL-2.1-or-later
"""Sofa.Core: nodes, objects, data and what scenes derive from."""
from .._base import Base  # noqa: F401
from .._data import Data, DataContainer, DataDict, DataString, DataVectorString  # noqa: F401
from .._node import Node  # noqa: F401
from .._objects import (  # noqa: F401
    Constraint, Controller, DataEngine, ForceField, Mapping, Mass, MissingType, Object)
from .._prefab import Prefab, RawPrefab  # noqa: F401

BaseObject = ObjectDeprecated = BaseData = Object
BaseNode = BaseContext = Node
BasePrefab = RawPrefab
BaseData = Data
DataLink = Data
ForceFieldVec1d = ForceFieldVec2d = ForceFieldVec3d = ForceFieldVec6d = ForceFieldRigid2d = ForceFieldRigid3d = ForceField
BaseForceField = ForceField
MassVec1d = MassVec3d = MassRigid3d = Mass
BaseMass = Mass


def CreateNode(name):
    return Node(name)


def __getattr__(name):
    """Classes that scenes name in annotations and ask for by isinstance(): all components are of one class here."""
    if name.startswith("Base") or name in ("MechanicalState", "Topology", "TopologyContainer", "LinearSolver", "OdeSolver"):
        return Object
    for word, kind in (("Mass", Mass), ("Mapping", Mapping), ("Constraint", Constraint), ("ForceField", ForceField)):
        if name.startswith(word):
            return kind
    from .. import _messages

    near = _messages.nearest(name, globals())
    raise AttributeError(f"Sofa.Core has no '{name}'" + (f"; did you mean '{near}'?" if near else ""))
