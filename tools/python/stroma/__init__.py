# SPDX-License-Identifier: LGPL-2.1-or-later
"""Simulation of soft tissue: scenes loaded or built in Python, stepped, with their states as arrays.

    import stroma
    sim = stroma.load("organ.xml", set={"/organ/fem.youngModulus": "12 kPa"})
    sim.run(until=0.5)
    print(sim.state("/organ").x[:, 1].min())
"""
from . import _stroma
from .blas import take_kernels

take_kernels(_stroma.instruction_level())  # before numpy is opened, or after
# pylint: disable=wrong-import-position
from .code import to_python
from .errors import LoadNeeded, OutputError, Problem, SceneError, SceneWarning, StepError, StromaError
from .formula import FormulaLaw
from .laws import Law
from .linear import Gradient, Modes
from .pictures import Picture
from .played import Constraint, ForceField
from .simulation import Force, LiveComponent, LiveNode, Observer, RunReport, Simulation, State, StepReport, load
from .studies import Recording, Run, Table, jacobian, read_monitor, read_recording, sweep
from .tree import Component, Node, Preview, from_xml, from_xml_text, to_xml
from .types import (Attribute, TypeInfo, advice, has_no_effect, is_known, nearest, present_type, type_info, types)

__version__ = _stroma.version


def threads() -> int:
    """How many threads a step may use. As many as pay for the size of each scene, unless set_threads() or the environment variable
    STROMA_THREADS gives the number."""
    return _stroma.threads()


def set_threads(count: int) -> None:
    """For the whole process and all scenes; no result depends on it."""
    _stroma.set_threads(count)


def __getattr__(name: str):
    """The types of components as classes: stroma.TetrahedronFEMForceField(youngModulus=3000)."""
    if not name.startswith("_") and name in types():
        made = _class_of(types()[name])
        globals()[name] = made
        return made
    near = nearest(name, list(types()) + list(globals())) if not name.startswith("_") else ""
    raise AttributeError(f"stroma has nothing called '{name}'" + (f"; did you mean '{near}'?" if near else ""))


def _class_of(info: TypeInfo) -> type:
    class _Doc(type(Component)):
        @property
        def __doc__(cls):
            return info.text()

        @property
        def __signature__(cls):
            if cls.__init__ is not __init__:  # of a class that is derived from it
                raise AttributeError("__signature__")
            return info.signature()

    def __init__(self, name=None, where=None, **attributes):
        Component.__init__(self, info.type, name, where, **attributes)
        from .tree import _check
        _check(self)

    return _Doc(info.type, (Component,), {"__init__": __init__, "__module__": "stroma"})


def __dir__():
    return sorted(set(globals()) | set(types()))
