# SPDX-License-Identifier: LGPL-2.1-or-later
"""Where visual models are. The engine draws none: the points of one are a state of a small scene that has the mappings of the
first and no forces, and is brought to where the first is when somebody reads them."""
import numpy as np
import stroma

from . import _catalogue
from ._mirror import Mirror

#: attributes of a visual model that a state has too
_TAKEN = {"position": "position", "vertices": "position", "restPositions": "position", "src": "src", "translation": "translation",
          "rotation": "rotation", "scale3d": "scale3d"}


def _is_placed(thing):
    """Not what reads a file by itself."""
    return thing._s_is_drawn() and not any(data is not None and data._s_raw for data in map(thing._s_data.get, ("filename", "fileMesh")))


class Drawing:
    def __init__(self, root):
        def wanted(thing):
            return _is_placed(thing) or thing._s_facts.role in _catalogue.COMPUTED_ROLES

        self._mirror = Mirror(root, wanted, keep_loaders=True, written_as=_as_state)
        self._mirror.root.add("EulerExplicitSolver", name="no_step_is_made")  # without, nothing brings the states to their mappings
        self._scene = stroma.load(self._mirror.root, dialect="sofa", observers=False, quiet=True)
        self._moved = [(key, self._scene.state(self._mirror.paths[key])) for key, thing in self._mirror.things.items()
                       if getattr(thing, "_s_type", "") and thing._s_facts.role == "mechanical state" and not _follows(thing)]

    def position(self, thing, places):
        """`places`: positions of a state of the scene that runs, by the id of its object; None of what is no part of it. Returns None
        of what is not placed here."""
        found = [(state, places(key)) for key, state in self._moved]
        has_changed = any(x is not None and x.shape != state.x.shape for state, x in found)
        if has_changed or id(thing) not in self._mirror.paths:
            return None
        for state, x in found:
            if x is not None:
                state.set(x=x)
        return np.array(self._scene.state(self._mirror.paths[id(thing)]).x)


def _as_state(thing):
    """(type, attributes by their names in the scene) of what stands for a visual model; None: it is written as it is."""
    return ("MechanicalObject", _TAKEN) if _is_placed(thing) else None


def _follows(thing):
    return any(each._s_type and each._s_facts.role == "mapping" for each in thing._s_node()._s_objects)
