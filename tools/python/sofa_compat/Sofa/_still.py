# SPDX-License-Identifier: LGPL-2.1-or-later
"""What SOFA's scenes leave to each body, and the engine wants of all that move together. In SOFA every body has a solver of its
own and contacts tie them; here bodies that touch are one system, with one kind of solver. And in SOFA what no solver moves stays
where it is, with all that is mapped from it; here something has to hold it."""
from . import _messages, _values

#: attributes of integrators that make no other step
_BESIDES = {"name", "printLog", "listening", "tags", "verbose"}
_DAMPING = ("rayleighStiffness", "rayleighMass")
_DAMPED = {"rayleighStiffness": "force field", "rayleighMass": "mass"}


def _of_role(node, role):
    return [each for each in node._s_objects if each._s_type and each._s_facts.role == role]


def _written(thing, besides=()):
    return {name: _values.to_text(data._s_raw) for name, data in thing._s_data.items()
            if data._s_raw is not None and name not in _BESIDES and name not in besides and thing._s_facts.find(name) is not None}


def _ties(thing):
    """It acts between two objects."""
    return any(name in thing._s_data and thing._s_data[name]._s_raw is not None for name in ("object1", "object2"))


def _present(thing):
    return thing._s_facts.info.type


class Still:
    """`instead`: of an object by id, (type, attributes) that take its place, or None: nothing does. `more`: attributes of an object
    that are others. `held`: nodes whose state is held, with what has to be added, [(type, attributes)]."""

    def __init__(self, root, is_moved, is_place):
        self.instead, self.more, self.held = {}, {}, {}
        nodes = list(root._s_all_nodes())
        self._moving = [node for node in nodes if _of_role(node, "integrator")]
        objects = [each for node in nodes for each in node._s_objects if each._s_type and each._s_facts.info is not None]
        can_touch = any(each._s_facts.role == "collision model" for each in objects)
        if not can_touch:  # the parts that look for contacts have nothing to look at
            seeking = ("CollisionPipeline", "CollisionResponse")
            self.instead.update({id(each): None for each in objects if _present(each) in seeking})
        if not self._moving:
            return
        still = [node for node in nodes if not is_moved(node) and self._leads(node, is_place)]
        answers = can_touch and any(_present(each) == "CollisionResponse" for each in objects)
        tied = answers or any(_ties(each) for each in objects)
        common = self._alike() if tied and len(self._moving) + len(still) > 1 else None
        for node in still:
            self._hold(node, still, common or (("EulerImplicitSolver", {}), ("SparseLDLSolver", {})))

    # ---- what nothing moves ----
    @staticmethod
    def _leads(node, is_place):
        """It has a state of its own, from which another one is mapped."""
        if len(_of_role(node, "mechanical state")) != 1 or _of_role(node, "mapping"):
            return False
        below = [child for child in node._s_children if is_place(child, node)]
        return any(_of_role(child, "mapping") and _of_role(child, "mechanical state") for child in below)

    def _hold(self, node, still, common):
        above = any(other is not node and node._s_is_below(other) for other in still)
        _messages.note(f"{node._s_place()}: no integrator moves it: it is held where it is, or where the scene puts it")
        self.held[id(node)] = ([] if above else list(common)) + [("FixedProjectiveConstraint", {"fixAll": True})]

    # ---- bodies that touch ----
    def _alike(self):
        """The (type, attributes) of the integrator and of the linear solver that all have from now on; None: they are left."""
        integrators = [_of_role(node, "integrator")[0] for node in self._moving]
        solvers = [_of_role(node, "linear solver") for node in self._moving]
        first = (_present(integrators[0]), _written(integrators[0], _DAMPING))
        if any((_present(each), _written(each, _DAMPING)) != first for each in integrators) or not all(solvers):
            return None
        damping = [{name: _values.like(0.0, each.findData(name).value) for name in _DAMPING} for each in integrators]
        shared = damping[0] if all(each == damping[0] for each in damping) else dict.fromkeys(_DAMPING, 0.0)
        kinds = [[(_present(each), _written(each)) for each in group] for group in solvers]
        integrator = (first[0], {**first[1], **shared})
        if all(each == kinds[0] for each in kinds) and len(kinds[0]) == 1 and shared is damping[0]:
            return integrator, kinds[0][0]
        solver = ("SparseLDLSolver", {})  # of all bodies together: the iterations that were enough for one may not be
        _messages.note("bodies that touch or are tied are one system here: their solvers are made alike, direct ones, "
                       + ", ".join(node.getPathName() for node in self._moving))
        for node, each, own, group in zip(self._moving, integrators, damping, solvers):
            self.more[id(each)] = {name: shared[name] for name in _DAMPING}
            if shared is not damping[0]:
                self._hand_down(node, own)
            self.instead.update({id(other): None for other in group[1:]})
            self.instead[id(group[0])] = solver
        return integrator, solver

    def _hand_down(self, node, damping):
        """The damping of an integrator becomes that of the force fields and masses that it moves."""
        for each in node._s_all_objects():
            if not each._s_type:
                continue
            for name, role in _DAMPED.items():
                if each._s_facts.role == role and damping[name] and each._s_facts.find(name) is not None:
                    own = _values.like(0.0, each.findData(name).value)
                    self.more[id(each)] = {**self.more.get(id(each), {}), name: own + damping[name]}
