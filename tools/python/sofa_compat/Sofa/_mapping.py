# SPDX-License-Identifier: LGPL-2.1-or-later
"""Mappings that a scene writes in SOFA's way, as the engine calls them."""
import numpy as np
import stroma

from . import _messages, _values
from ._force_field import Rows, told
from ._objects import Object

_ENTRIES = 4_000_000  # of a Jacobian that is found by columns
_SWITCHES = {"mapForces": True, "mapConstraints": True, "mapMasses": True, "mapMatrices": False}


class Mapping(Object):
    """A mapping written in Python: apply(self, m, out, in), applyJ(self, m, out, in) and applyJT(self, m, out, in), where `out` is
    written. What SOFA calls applyConstraintsJT() is made of applyJ() here, and is not called."""

    def _s_sample_of(self, name):
        if name in ("input", "output"):
            return "", "a state"
        return (_SWITCHES[name], "") if name in _SWITCHES else super()._s_sample_of(name)

    def _s_state(self, name):
        """`input` or `output`; what is not written is above, or in this node."""
        raw = self.findData(name)._s_raw
        found = raw if isinstance(raw, Object) else self._s_linked(str(raw), name) if raw else None
        if isinstance(found, Object):
            return found
        if raw:
            raise ValueError(f"{self._s_place()}.{name}: {raw} leads to no state")
        node = self._s_node() if name == "output" else self._s_node()._s_node()
        while name == "input" and node is not None and node.getMechanicalState() is None:
            node = node._s_node()
        return None if node is None else node.getMechanicalState()

    def apply(self, m, out, given):
        raise NotImplementedError(f"{self._s_place()}: a mapping needs apply()")

    def applyJ(self, m, out, given):
        raise NotImplementedError(f"{self._s_place()}: a mapping needs applyJ()")

    def applyJT(self, m, out, given):
        raise NotImplementedError(f"{self._s_place()}: a mapping needs applyJT()")

    def applyConstraintsJT(self, *_):
        """Constraints on what follows use applyJ()."""

    def getFrom(self):
        return [self._s_state("input")]

    def getTo(self):
        return [self._s_state("output")]


class _Side:
    """A state as the mapping sees it: how many nodes and numbers, and which of the engine's."""

    def __init__(self, state):
        template = _values.plain_template(state._s_template()) or "Vec3"
        if template == "Rigid2":
            raise ValueError(f"{state._s_place()}: a mapping in Python is not from or to Rigid2 here: Rigid3 has its numbers")
        self.places = np.array(state.findData("position").value, dtype=float)
        self.nodes, self.is_flat, self.has_frames = len(self.places), template == "Vec2", template == "Rigid3"
        self.seen = None  # columns, of those that the engine has

    def size(self, width):
        """As the engine has its nodes: those of a plane as points or as two numbers."""
        self.seen = 2 if self.is_flat and width == 3 else None
        self.width, self.is_place = 6 if self.has_frames else width, self.has_frames or width == 3

    def shown(self, array):
        return Rows(array if self.seen is None else array[:, :self.seen])

    def full(self, places):
        """In the engine's columns."""
        return np.pad(places, ((0, 0), (0, 1))) if self.seen and places.shape[1] == 2 else places

    def row_and_number(self, numbers):
        return (numbers // 3, numbers % 3) if self.is_place else (numbers, np.zeros_like(numbers))


class _Seen:
    """A mapping as the engine sees it."""

    def __init__(self, played):
        self.mapping = mapping = played.mapping
        self.start, self.end = (_Side(mapping._s_state(name)) for name in ("input", "output"))
        self.places = self.end.places  # of the child, after the last apply()
        self.is_looked_at = False
        self.is_apart, self.pairs = None, None

    def size(self, of_start, of_end):
        self.start.size(of_start)
        self.end.size(of_end)
        self.places = self.end.full(self.places)

    def _parameters(self):
        root = self.mapping.getRoot()
        return {"time": root.getTime(), "mFactor": 1.0, "bFactor": 0.0, "kFactor": 1.0, "isImplicit": True, "energy": False}

    def _called(self, name, out, given, side_out, side_in):
        getattr(self.mapping, name)(self._parameters(), side_out.shown(out), side_in.shown(given))
        return out

    def apply(self, x):
        found = told(self.mapping, lambda: self._called("apply", np.array(self.places), x, self.end, self.start))
        if found is None:
            return np.full_like(self.places, np.nan)
        self.places, self.at = found, x
        if not self.is_looked_at:
            self.is_looked_at = True
            told(self.mapping, self._look)
        return found

    def _zeros(self, side):
        return np.zeros((side.nodes, side.width))

    def applyJ(self, v):
        found = told(self.mapping, lambda: self._called("applyJ", self._zeros(self.end), v, self.end, self.start))
        return np.full((self.end.nodes, self.end.width), np.nan) if found is None else found

    def applyJT(self, f):
        found = told(self.mapping, lambda: self._called("applyJT", self._zeros(self.start), f, self.start, self.end))
        return np.full((self.start.nodes, self.start.width), np.nan) if found is None else found

    # ---- whether the three belong together ----
    def _look(self):
        """Once. A scene that forgets one of them runs in SOFA, and moves in another way than it says."""
        random, place = np.random.default_rng(0), self.mapping._s_place()
        v, f = (self._free(random.normal(size=(side.nodes, side.width)), side) for side in (self.start, self.end))
        moved = self._called("applyJ", self._zeros(self.end), v, self.end, self.start)
        back = self._called("applyJT", self._zeros(self.start), f, self.start, self.end)
        one, other = (f * moved).sum(), (back * v).sum()
        if abs(one - other) > 1e-6 * max(np.abs(f * moved).sum(), np.abs(back * v).sum()):
            _messages.warn(f"{place}: applyJT() is not the transposed of applyJ(): forces on what follows do another work than its motion")
        if self.start.has_frames or self.end.has_frames:
            return
        size = max(np.ptp(self.at), np.ptp(self.places), 1e-6)
        places = np.array(self.places)
        way = 1e-6 * size * v / np.abs(v).max()
        difference = self._called("apply", np.array(places), self.at + way, self.end, self.start) - places
        self._called("apply", np.array(places), self.at, self.end, self.start)  # what it keeps for its derivative
        expected = 1e-6 * size / np.abs(v).max() * moved
        if np.abs(difference - expected).max() > 1e-3 * max(np.abs(difference).max(), np.abs(expected).max()) + 1e-12 * size:
            _messages.warn(f"{place}: applyJ() is not the derivative of apply(): velocities and forces of what follows are not those of its "
                           "positions")

    @staticmethod
    def _free(numbers, side):
        if side.seen is not None:
            numbers[:, side.seen:] = 0
        return numbers

    # ---- J ----
    def jacobian(self):
        found = told(self.mapping, self._jacobian)
        return (np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros((0, 3, 3))) if found is None else found

    def _product(self, v):
        return self._called("applyJ", self._zeros(self.end), v, self.end, self.start)

    def _jacobian(self):
        """A block for each node where each follows its own alone, as most do. Else a column for each number, which lead to all pairs."""
        if self.is_apart is not False and self.start.nodes == self.end.nodes and not self.start.has_frames and self.start.is_place and (
                self.end.is_place and not self.end.has_frames):
            blocks = np.stack([self._product(self._free(np.tile(axis, (self.start.nodes, 1)), self.start)) for axis in np.eye(3)], axis=2)
            v = self._free(np.random.default_rng(0).normal(size=(self.start.nodes, 3)), self.start)
            expected, found = np.einsum("nij,nj->ni", blocks, v), self._product(v)
            if not np.abs(found - expected).max(initial=0) > 1e-9 * np.abs(found).max(initial=0):
                self.is_apart = True
                nodes = np.arange(self.start.nodes, dtype=np.int32)
                return nodes, nodes, blocks
            if self.is_apart:
                raise ValueError(f"{self.mapping._s_place()}: a node follows others than before")
        self.is_apart = False
        columns, rows = self.start.nodes * self.start.width, self.end.nodes * self.end.width
        if columns * rows > _ENTRIES:
            raise ValueError(f"{self.mapping._s_place()}: a mapping in Python of {self.start.nodes} nodes to {self.end.nodes} that each "
                             "follow several has no matrix here: CGLinearSolver needs none")
        whole = np.zeros((rows, columns))
        for number in range(columns):
            unit = self._zeros(self.start)
            unit.flat[number] = 1
            whole[:, number] = self._product(unit).ravel()
        return self._in_blocks(whole)

    def _in_blocks(self, whole):
        """Of all pairs of rows, whatever is zero now."""
        (rows, at_row), (columns, at_column) = (side.row_and_number(np.arange(count)) for side, count in zip((self.end, self.start), whole.shape))
        blocks = np.zeros((rows[-1] + 1, columns[-1] + 1, 3, 3))
        blocks[rows[:, None], columns[None, :], at_row[:, None], at_column[None, :]] = whole
        if self.pairs is None:
            self.pairs = [each.ravel().astype(np.int32) for each in np.meshgrid(range(rows[-1] + 1), range(columns[-1] + 1), indexing="ij")]
        return self.pairs[0], self.pairs[1], blocks.reshape(-1, 3, 3)


class Played(stroma.played.Played):
    """The object that the engine calls for a mapping of the scene."""

    component = "PythonMapping"
    _kind = _Seen
