# SPDX-License-Identifier: LGPL-2.1-or-later
"""Sofa.Core: nodes, objects, data and what scenes derive from."""
from types import SimpleNamespace

from .. import _mapping, _objects
from .._base import Base, LinkPath  # noqa: F401
from .._contacts import ContactListener  # noqa: F401
from .._data import Data, DataContainer, DataDict, DataString, DataVectorString, Writing  # noqa: F401
from .._modifier import Modifier as PointSetTopologyModifier  # noqa: F401
from .._node import Node, Sequence  # noqa: F401
from .._objects import Controller, DataEngine, MissingType, Object  # noqa: F401
from .._prefab import Prefab, RawPrefab  # noqa: F401

BaseObject = ObjectDeprecated = Component = Object
BaseNode = BaseContext = Context = Node
NodeIterator, WriteAccessor, DataContainerContext = Sequence, Writing, Writing
BasePrefab = RawPrefab
BaseData = DataLink = Link = Data


class _OfRole(type):
    """isinstance(component, Sofa.Core.BaseMass): all components are of one class here, and their types have roles."""

    def __instancecheck__(cls, thing):
        if super().__instancecheck__(thing):
            return True
        facts = thing._s_facts if isinstance(thing, Object) and "_s_role" in cls.__dict__ else None
        return facts is not None and facts.role == cls._s_role


def _class(name, role, base=Object):
    return _OfRole(name, (base,), {"_s_role": role, "__doc__": base.__doc__, "__module__": __name__})


_PLAYED = {"ForceField": "force field", "Mass": "mass", "Mapping": "mapping", "Constraint": "Lagrangian constraint"}
_ROLES = {"MechanicalState": "mechanical state", "State": "mechanical state", "Topology": "topology", "MeshTopology": "topology",
          "TopologyContainer": "topology", "LinearSolver": "linear solver", "OdeSolver": "integrator", "MeshLoader": "mesh loader",
          "Loader": "mesh loader", "ProjectiveConstraintSet": "projective constraint", "CollisionModel": "collision model"}
ForceField, Mass, Mapping, Constraint = (_class(name, role, _mapping.Mapping if name == "Mapping" else getattr(_objects, name))
                                         for name, role in _PLAYED.items())
BaseForceField, BaseMass, BaseMapping, BaseConstraint = ForceField, Mass, Mapping, Constraint


class _Types(type):
    @property
    def components(cls):
        """An entry for each type."""
        import stroma

        return [SimpleNamespace(className=name, description=info.help, aliases=[], templates=[], defaultTemplate="", targets=[info.module],
                                dataAlias={}, locations=[], authors="", license="") for name, info in stroma.types().items()]


class ObjectFactory(metaclass=_Types):
    """The types that a scene can name."""

    @staticmethod
    def getComponent(name):
        """None: there is none of that name."""
        return next((each for each in ObjectFactory.components if each.className == str(name)), None)


class TaskScheduler:
    """Threads of the engine: as many as the machine has cores, unless a scene asks for others. Results do not depend on them."""

    @staticmethod
    def init(threads=0):
        from stroma import _stroma

        if int(threads) > 0:
            _stroma.set_threads(int(threads))

    @staticmethod
    def stop():
        """Threads that have nothing to do wait."""

    @staticmethod
    def getThreadCount():
        from stroma import _stroma

        return _stroma.threads()


def __getattr__(name):
    """Classes that scenes name in annotations, ask for by isinstance() and derive from: ForceFieldVec3d, BaseMechanicalState."""
    for word in _PLAYED:
        if name.startswith(word):
            return globals()[word]
    role = _ROLES.get(name[4:] if name.startswith("Base") else name)
    if role is not None:
        made = globals()[name] = _class(name, role)
        return made
    if name.startswith("Base"):
        return Object
    from .. import _messages

    near = _messages.nearest(name, globals())
    raise AttributeError(f"Sofa.Core has no '{name}'" + (f"; did you mean '{near}'?" if near else ""))
