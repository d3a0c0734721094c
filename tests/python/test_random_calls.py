# SPDX-License-Identifier: LGPL-2.1-or-later
"""Random calls with right and wrong arguments: each returns or raises an exception of Python, and the scene still runs. Arrays,
components and states are used when their simulation has gone, was reset or has another mesh. STROMA_RANDOM_CALLS=25000 makes a
hundred thousand calls."""
import gc
import os
import random

import numpy
import pytest
import stroma
from conftest import block

VALUES = [None, True, -1, 0, 3, 10**30, 1.5, float("nan"), float("inf"), "", "@", "@/body/fem", "12 kPa", "many", b"bytes", (), [],
          [1, 2, 3], [[1, 2], [3]], {"a": 1}, object(), numpy.zeros(3), numpy.zeros((100, 3)), numpy.full((100, 3), numpy.nan),
          numpy.zeros((2, 2, 2)), numpy.array(["a"]), numpy.array(None), range(5), lambda *_: 1 / 0]
EXPECTED = (stroma.StromaError, TypeError, ValueError, AttributeError, ZeroDivisionError, LookupError, OverflowError)
PATHS = ["/", "", "/body", "/body/fem", "body/fem", "/body/dofs", "/body/held", "/linear", "/solver", "/nothing", "//", "@", 3, None]
NAMES = ["youngModulus", "poissonRatio", "iterations", "position", "indices", "gravity", "dt", "name", "mstate", "method", "x", "",
         "__doc__", 7]
CALLS = int(os.environ.get("STROMA_RANDOM_CALLS", 2500))  # of each seed


class Caller:
    def __init__(self, seed):
        self.random = random.Random(seed)
        self.simulation = stroma.load(block())
        self.tree = block()
        self.kept, self.parts = [], []
        self.marks = [b"", b"stroma checkpoint 1\n", self.simulation.checkpoint()]

    def any(self, *lists):
        return self.random.choice(self.random.choice([VALUES, *lists, *lists, *lists]))

    def replace(self):
        """By one of another mesh, or of the same; what was taken from the one before stays."""
        self.parts += [self.simulation["/body/fem"], self.simulation["/body"], self.simulation.state(), self.simulation.state().mesh()]
        self.parts = self.parts[-20:]
        self.simulation = stroma.load(block(), set=self.random.choice([{}, {}, {"/body/grid.n": "3 3 3"}]))

    def use_what_is_left(self):
        part = self.random.choice(self.parts)
        return (part.youngModulus if hasattr(part, "youngModulus") else 0, getattr(part, self.random.choice(["x", "v", "gravity", "points"]), None),
                self.random.choice(self.kept).sum(), repr(part))

    def once(self):
        simulation, tree = self.simulation, self.tree
        pick = self.random.choice([
            lambda: simulation.step(),
            lambda: simulation.step(self.any([0.01, 0.005])),
            lambda: simulation.run(self.any([1, 2]) if self.random.random() < 0.2 else 1),
            lambda: simulation.run(until=simulation.time + 0.01),
            lambda: simulation.reset(),
            lambda: simulation[self.any(PATHS)],
            lambda: setattr(simulation[self.any(PATHS)], self.any(NAMES), self.any([1000, 0.3])),
            lambda: getattr(simulation[self.any(PATHS)], self.any(NAMES)),
            lambda: simulation.set(self.any(["/body/fem.youngModulus", "dt", "/gravity", "gravity", "."]), self.any([5000])),
            lambda: self.kept.append(simulation.state(self.any(PATHS)).x),
            lambda: self.kept.append(simulation.state().v[self.any([1, 2, 3])]),
            lambda: simulation.state().set(x=self.any([simulation.state().start]), v=self.any(), nodes=self.any([[1]])),
            lambda: simulation.state().f,
            lambda: simulation.request_forces(),
            lambda: simulation.add_force(self.any(["/body"]), self.any([[1], [2, 3]]), force=self.any([(0, 1, 0)]),
                                         stiffness=self.any([0])).remove(),
            lambda: self.marks.append(simulation.checkpoint()) if len(self.marks) < 9 else None,
            lambda: simulation.restore(self.any(self.marks)),
            lambda: simulation.on_step_begin(self.any()).remove(),
            lambda: simulation.matrix(self.any(["stiffness", "mass"]), self.any([True])) if self.random.random() < 0.02 else None,
            lambda: simulation.state().mesh(),
            lambda: self.tree.add(self.any(list(stroma.types())[:20]), self.any(["fem"]), **{str(self.any(NAMES)): self.any()}),
            lambda: tree[self.any(PATHS)],
            lambda: tree.remove(self.random.choice(tree.components)),
            lambda: setattr(tree["/body/fem"], self.any(NAMES), self.any()),
            lambda: tree["/body/top"].indices if self.random.random() < 0.2 else None,
            lambda: stroma.to_xml(tree) if self.random.random() < 0.1 else None,
            lambda: stroma.type_info(self.any(list(stroma.types()))),
            lambda: stroma.load(tree) if self.random.random() < 0.05 else None,
            lambda: self.kept.clear() if len(self.kept) > 50 else None,
            lambda: self.replace() if self.random.random() < 0.05 else None,
            self.use_what_is_left,
            lambda: setattr(self.random.choice(self.parts), self.any(NAMES), self.any()),
        ])
        pick()


@pytest.mark.parametrize("seed", range(4))
def test_random_calls(seed):
    caller = Caller(seed)
    raised = 0
    for _ in range(CALLS):
        try:
            caller.once()
        except EXPECTED:
            raised += 1
    assert raised > 100
    for array in caller.kept:
        float(numpy.asarray(array).sum())
    fresh = stroma.load(block())
    if len(caller.simulation.state().x) != len(fresh.state().x):
        caller.simulation = stroma.load(block())
    caller.simulation.restore(caller.marks[2])
    caller.simulation.run(2)
    fresh.run(2)
    assert caller.simulation.hash == fresh.hash, "what was refused, and what was taken back, has left nothing"
    gc.collect()
