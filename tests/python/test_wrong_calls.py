# SPDX-License-Identifier: LGPL-2.1-or-later
"""Ten thousand calls with what they cannot take: an exception of Python each, and the simulation is what it was."""
import random

import numpy
import pytest
import stroma
from conftest import block

EXPECTED = (stroma.StromaError, TypeError, ValueError, AttributeError, LookupError, OverflowError)
NO_NUMBERS = ["many", "", None, object(), {"a": 1}, {1, 2}, b"bytes", [None], ["a", "b"], lambda: 0, print, type, numpy.array("a"),
              numpy.array([object()]), 3 + 4j]


class Wrong:
    """Makes what is wrong, by a seed."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.numpy = numpy.random.default_rng(seed)

    def no_numbers(self):
        return self.random.choice(NO_NUMBERS)

    def shape(self):
        while True:
            shape = tuple(self.random.choice([0, 1, 2, 3, 4, 7, 99, 100, 101, 300]) for _ in range(self.random.randint(0, 4)))
            if shape != (100, 3) and numpy.prod(shape, dtype=float) < 1e6:
                return shape

    def array(self):
        """Of another shape, of another kind, or with numbers that are none."""
        kind = self.random.randrange(4)
        if kind == 0:
            return self.numpy.normal(size=self.shape())
        if kind == 1:
            return self.numpy.integers(-5, 5, size=self.shape()).astype(self.random.choice([numpy.int8, numpy.uint64, bool, float]))
        if kind == 2:
            bad = numpy.zeros((100, 3))
            bad.flat[self.random.randrange(300)] = self.random.choice([numpy.nan, numpy.inf, -numpy.inf])
            return bad
        return numpy.full((100, 3), self.random.choice(["a", None, object()]))

    def path(self):
        return self.random.choice(["/nothing", "/body/fme", "//", "/body/fem/", "@/body/fem", "/body/fem.youngModulus", 3, 2.5, object(), [], ()])

    def nodes(self):
        return self.random.choice([[100], [-1], [10**9], [2**40], [0.5], ["a"], [[1, 2]], "all", 7.5, [None], numpy.zeros((2, 2))])


def calls(wrong, simulation, tree):
    """A call that has to be refused, by its name."""
    state, fem, chance = simulation.state(), simulation["/body/fem"], wrong.random
    return {
        "positions": lambda: state.set(x=wrong.array()),
        "velocities": lambda: state.set(v=wrong.array()),
        "no positions": lambda: state.set(x=chance.choice(NO_NUMBERS[:2] + NO_NUMBERS[3:])),
        "attribute x": lambda: setattr(state, "x", wrong.array()),
        "a view": lambda: state.x.__setitem__(chance.choice([0, (0, 0), slice(None), ...]), 1.0),
        "no entry": lambda: state.x[chance.choice([100, -101, (0, 3), "a", (0, 0, 0), 1.5])],
        "step": lambda: simulation.step(chance.choice(["a", "", [1], {}, -1, 0, float("nan"), float("inf"), object()])),
        "steps": lambda: simulation.run(chance.choice(["a", 1.5, -1, [], {}, object(), float("nan"), 10**30])),
        "until": lambda: simulation.run(until=chance.choice([-1, float("nan"), [], {}, object(), "soon"])),
        "no limit": lambda: simulation.run(),
        "path": lambda: simulation[wrong.path()],
        "state": lambda: simulation.state(chance.choice(["/nothing", "/body/fem", 3, 2.5, [], object()])),
        "value": lambda: setattr(fem, chance.choice(["youngModulus", "poissonRatio"]), chance.choice(
            NO_NUMBERS[:1] + NO_NUMBERS[3:] + [-5, "0.7 0.8 0.9", float("nan"), float("inf"), "12 kilograms", [1, 2, 3, 4, 5]])),
        "no attribute": lambda: setattr(fem, chance.choice(["youngModulos", "", "x", "name", "path", "where"]), 1),
        "read": lambda: getattr(fem, chance.choice(["youngModulos", "nothing", "x" * 1000])),
        "what restarts": lambda: setattr(simulation["/body/grid"], "n", chance.choice([[2, 2, 2], "a", None, [0], -1])),
        "set": lambda: simulation.set(chance.choice(["", ".", "/", "/body", "/body/fem", "/body/fem.", "fem.x", "dt."]), 1),
        "dt": lambda: setattr(simulation, "dt", chance.choice(["a", -1, float("nan"), [], [1, 2], object(), None])),
        "gravity": lambda: setattr(simulation, "gravity", chance.choice(["a", 1, [1, 2], object(), [1, 2, float("nan")], {"x": 1}])),
        "force nodes": lambda: simulation.add_force(state, wrong.nodes(), force=(0, 1, 0)),
        "force": lambda: simulation.add_force(state, [1], force=chance.choice(["a", 1, (1, 2), (1, 2, 3, 4), object(), (0, float("nan"), 0), None])),
        "force state": lambda: simulation.add_force(chance.choice(["/nothing", 3, None and 1, object(), []]) or "/x", [1], force=(0, 1, 0)),
        "targets": lambda: simulation.add_force(state, [1], targets=chance.choice([[[1, 2]], [[0, 0, 0]] * 2, "a", [1], [[None] * 3]]), stiffness=1),
        "checkpoint": lambda: simulation.restore(chance.choice([b"", b"x" * 100, "text", None, 3.5, [300], object(), numpy.zeros(9)])),
        "matrix": lambda: simulation.matrix(chance.choice(["", "stifness", 3, None, object()])),
        "field": lambda: fem.field(chance.choice(["", "vonMeses", 3, None, object()])),
        "cell data": lambda: state.mesh().cell_data(chance.choice(["", "vonMeses", 3, None, object(), ["x"]])),
        "observer": lambda: simulation.add_observer(wrong.no_numbers()),
        "load": lambda: stroma.load(chance.choice([3, None, object(), "", "/nothing.xml", "scene.py", [], b"x", numpy.zeros(3), tree["/body"]["fem"]])),
        "load set": lambda: stroma.load(tree, set=chance.choice([{"": 1}, {"/body/fem": 1}, {"/body/fem.youngModulos": 1}, {3: 1}, {"dt": object()},
                                                                 {"dt": "fast"}, {"/nothing.x": 1}, [1], "a", {"dt": -1}])),
        "tree type": lambda: tree.add(chance.choice(["", "Nothing", "TetrahedronFEMForceFeld", 3, 2.5, object(), [], b"x"])),
        "tree attribute": lambda: tree.add("MechanicalObject", **{chance.choice(["positon", "a", "_x" and "x"]): 1}),
        "tree value": lambda: stroma.to_xml(stroma.Node("r")) and stroma.load(_with(tree, chance.choice([object(), {"a": 1}, 3j, {1}, lambda: 0]))),
        "tree path": lambda: tree[chance.choice(["/nothing", "body/nothing", 3, 2.5, object(), []])],
        "tree remove": lambda: tree.remove(chance.choice([None, 3, "body", stroma.Node("other"), object()])),
        "xml": lambda: stroma.from_xml_text(chance.choice(["", "<", "<Node>", "text", "<Node a='1' a='2'/>", "<Other/>", "<Node><A></B></Node>"])),
        "law": lambda: stroma.Law(chance.choice([numpy.zeros((3, 3)), "a", None, numpy.eye(4)[:, :3], [[1, 2], [3]]]),
                                  chance.choice([[[0, 1, 2, 3]], [[0, 1, 2]], "a", None, [[0, 1, 2, 9]], [[0.5, 1, 2, 3]]])),
        "formula": lambda: stroma.FormulaLaw(numpy.r_[numpy.zeros((1, 3)), numpy.eye(3)], [[0, 1, 2, 3]],
                                             chance.choice(["", "x", "I1 +", "f(I1)", "I1.a", "[J]", "mu * I1 * q"]), mu=1.0),
        "held": lambda: stroma.load(_held(chance.choice([[100], [-1], [0.5], ["a"], [[1]], None, [2**40]]))),
        "jacobian": lambda: stroma.jacobian(lambda p: p, wrong.no_numbers()),
        "recording": lambda: stroma.read_recording(chance.choice(["/nothing", "", 3, None, object(), "."])),
        "threads": lambda: stroma.set_threads(chance.choice([0, -1, 10**9, 1.5, "a", None])),
        "copy": lambda: __import__("pickle").dumps(simulation),
    }


def _with(tree, value):
    root = block()
    root["body"]["dofs"].position = value
    return root


def _held(nodes):
    root = block()
    root["body"].add(stroma.Constraint(nodes=nodes), name="more")
    return root


@pytest.mark.parametrize("seed", range(4))
def test_every_wrong_call_is_refused(seed, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    wrong = Wrong(seed)
    simulation, tree = stroma.load(block()), block()
    simulation.run(3)
    before, taken = simulation.hash, []
    possible = calls(wrong, simulation, tree)
    rarely = {"load", "load set", "held", "tree value", "matrix"}
    names = [name for name in possible for _ in range(1 if name in rarely else 12)]
    for count in range(2500):
        name = wrong.random.choice(names)
        try:
            found = possible[name]()
        except EXPECTED:
            continue
        taken.append((count, name, found))
    assert not taken, "these were taken"
    assert simulation.hash == before and simulation.steps == 3
    simulation.run(2)
    fresh = stroma.load(block())
    fresh.run(5)
    assert simulation.hash == fresh.hash, "what was refused has left nothing"
