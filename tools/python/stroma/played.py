# SPDX-License-Identifier: LGPL-2.1-or-later
"""Force fields and constraints written in Python: slow, and as simple as NumPy."""
import itertools
import threading
import weakref
from typing import Any, Dict, Optional, Sequence, Tuple

import numpy

_numbers = itertools.count(1)
#: What has a number, as long as a scene or a simulation holds it.
_played: "weakref.WeakValueDictionary[int, _Seen]" = weakref.WeakValueDictionary()
_lock = threading.Lock()


def take(number: int) -> Any:
    """What the engine looks up by the attribute `played`."""
    with _lock:
        found = _played.get(number)
    if found is None:
        raise LookupError(f"no Python object has the number {number}: a PythonForceField is of the program that made the scene")
    return found


class Played:
    """What a component of the engine calls; a node adds it as it adds components."""

    component = ""  #: its type
    _kind: Any = None

    def __init__(self, **values: Any):
        for name, value in values.items():
            setattr(self, name, value)

    @property
    def number(self) -> int:
        """By which the component finds it."""
        with _lock:
            if "_seen" not in self.__dict__:
                self._seen = self._kind(self)
                self._seen.number = next(_numbers)
                _played[self._seen.number] = self._seen
        return self._seen.number


class ForceField(Played):
    """A force on the nodes of a state. Derive from it, override force(), and add it to a node:

        class Pull(stroma.ForceField):
            def force(self, x, v, t):
                return -self.k * (x - self.at)

        node.add(Pull(k=5.0, at=0.0), name="pull")

    Of frames x is (n, 7), v and the force (n, 6); of numbers they have a column for each of a node.

    Override stiffness() for implicit steps that see its derivative, and energy() where there is one. Without a stiffness the
    force is taken as it is at the start of a step: explicit, and stable only as long as that is small. A force that does not
    depend on t may say so: time_dependent = False."""

    component = "PythonForceField"
    linear = False  #: the force is affine in x
    symmetric = True  #: the stiffness is
    exact_tangent = True  #: the stiffness is the derivative of the force
    time_dependent = True  #: t is that of the step; else it stays 0

    def force(self, x: numpy.ndarray, v: numpy.ndarray, t: float) -> numpy.ndarray:
        """The force on each node, (n, 3) [N], at positions x [m] and velocities v [m/s], (n, 3)."""
        raise NotImplementedError

    def energy(self, x: numpy.ndarray) -> float:
        """[J]"""
        raise NotImplementedError

    def stiffness(self, x: numpy.ndarray, v: numpy.ndarray, t: float) -> Any:
        """dF/dx: a matrix of SciPy or NumPy, (3n, 3n), or one block for each node, (n, 3, 3)."""
        raise NotImplementedError

    def check(self, x: Any, v: Any = None, t: float = 0.0, step: float = 1e-6) -> Dict[str, float]:
        """How far what it says of itself is from differences of its force, at positions x: {"energy": ..., "stiffness": ...}, as parts
        of the largest number; only what it has. Differences themselves are good to about 1e-8."""
        x = numpy.array(x, float)
        v = numpy.zeros_like(x) if v is None else numpy.array(v, float)
        h = step * max(numpy.ptp(x), step)
        force = numpy.asarray(self.force(x.copy(), v.copy(), t), float)
        seen, off = _Seen(self), {}

        def moved(index: int, way: float) -> numpy.ndarray:
            place = x.copy()
            place.flat[index] += way
            return place
        if seen.has_energy:
            slope = [(self.energy(moved(i, h)) - self.energy(moved(i, -h))) / (2 * h) for i in range(x.size)]
            off["energy"] = float(numpy.abs(force.ravel() + slope).max() / max(numpy.abs(force).max(), 1e-300))
        if seen.has_stiffness:
            columns = [(self.force(moved(i, h), v, t) - self.force(moved(i, -h), v, t)).ravel() / (2 * h) for i in range(x.size)]
            rows, places, blocks = seen.stiffness(x, v, t)
            whole = numpy.zeros((x.size, x.size))
            for row, place, block in zip(rows, places, blocks):
                whole[3 * row:3 * row + 3, 3 * place:3 * place + 3] += block
            off["stiffness"] = float(numpy.abs(whole - numpy.stack(columns, axis=1)).max() / max(numpy.abs(whole).max(), 1e-300))
        return off


class _Seen:
    """A force field as the engine sees it."""

    def __init__(self, field: ForceField):
        self.field = field
        kind = type(field)
        self.has_energy = kind.energy is not ForceField.energy
        self.has_stiffness = kind.stiffness is not ForceField.stiffness
        self.linear, self.symmetric = bool(field.linear), bool(field.symmetric)
        self.exact_tangent, self.time_dependent = bool(field.exact_tangent), bool(field.time_dependent)
        self.is_looked_at = not self.symmetric

    def force(self, x, v, t):
        force = self.field.force(x, v, t)
        if numpy.iscomplexobj(force):  # else the imaginary part would be dropped
            raise TypeError(f"the force of {type(self.field).__name__} is complex: expected real numbers, (n, 3) [N]")
        return force

    def energy(self, x):
        return float(self.field.energy(x))

    def stiffness(self, x, v, t):
        matrix, nodes = self.field.stiffness(x, v, t), len(v) * v.shape[1] // 3 if v.shape[1] in (3, 6) else v.size
        rows, columns, blocks = blocks_of(matrix, nodes) if v.shape[1] in (3, 6) else _of_numbers(matrix)
        if not self.is_looked_at:  # once: a solver for symmetric matrices would be wrong without a word
            self.is_looked_at = True
            if not _is_symmetric(rows, columns, blocks, nodes):
                raise ValueError(f"the stiffness of {type(self.field).__name__} is not symmetric: say so, symmetric = False")
        return rows, columns, blocks


ForceField._kind = _Seen


class Constraint(Played):
    """Holds nodes of a state, or moves them. Derive from it, override what differs, and add it to a node:

        class Push(stroma.Constraint):
            def motion(self, t):
                return self.start + (0, 0, 0.01 * t), numpy.tile((0, 0, 0.01), (len(self.nodes), 1))

        node.add(Push(nodes=[3, 4], start=points[[3, 4]]), name="push")

    Without motion() the nodes stay where they are. `along`: directions that are held, one vector for all nodes or one for each;
    none: all three."""

    component = "PythonConstraint"
    constant = True  #: the same nodes and directions at all times
    nodes: Sequence[int] = ()
    along: Any = None

    def held(self, t: float) -> Tuple[Any, Any]:
        """(nodes (m,), directions): what is held in the step that ends at time t [s]; directions None: all, or vectors (m, 3), or
        projectors (m, 3, 3) of what is left free."""
        return self.nodes, self.along

    def motion(self, t: float) -> Tuple[Any, Any]:
        """Where the held nodes are at time t, and how fast: positions (m, 3) [m], velocities (m, 3) [m/s]. Only what is held
        counts."""
        raise NotImplementedError


class _SeenConstraint:
    """A constraint as the engine sees it."""

    def __init__(self, constraint: Constraint):
        self.constraint = constraint
        self.constant = bool(constraint.constant)
        self.has_motion = type(constraint).motion is not Constraint.motion

    def held(self, t):
        nodes, directions = self.constraint.held(t)
        nodes = numpy.asarray(nodes)
        if nodes.ndim != 1 or (nodes.size and nodes.dtype.kind not in "iu"):
            raise ValueError(f"the nodes of {type(self.constraint).__name__} are no list of whole numbers")
        return nodes.astype(numpy.int32), projectors_of(directions, len(nodes))

    def motion(self, t):
        return tuple(self.constraint.motion(t))


Constraint._kind = _SeenConstraint


def projectors_of(directions: Optional[Any], nodes: int) -> numpy.ndarray:
    """(nodes, 3, 3) of held directions: I - n n^T / n.n of vectors n, zero of all."""
    if directions is None:
        return numpy.zeros((nodes, 3, 3))
    directions = numpy.asarray(directions, float)
    if directions.shape == (nodes, 3, 3) and directions.ndim == 3:
        return directions
    vectors = numpy.broadcast_to(directions, (nodes, 3))
    size = numpy.einsum("mi,mi->m", vectors, vectors)
    if not (size > 0).all():
        raise ValueError("a direction that is held has no length")
    return numpy.eye(3) - numpy.einsum("mi,mj,m->mij", vectors, vectors, 1 / size)


def _is_symmetric(rows: Any, columns: Any, blocks: Any, nodes: int) -> bool:
    """For any vectors a and b, a K b = b K a: two tell with certainty, as good as."""
    random = numpy.random.default_rng(0)
    a, b = random.normal(size=(nodes, 3)), random.normal(size=(nodes, 3))
    one = numpy.einsum("mi,mij,mj", a[rows], blocks, b[columns])
    other = numpy.einsum("mi,mij,mj", b[rows], blocks, a[columns])
    size = numpy.einsum("mi,mij,mj", abs(a[rows]), abs(numpy.asarray(blocks)), abs(b[columns]))
    return not abs(one - other) > 1e-9 * size  # one without a value ends the step anyhow


def _of_numbers(matrix: Any) -> tuple:
    """The same of a state of numbers, which has a row for each."""
    from scipy.sparse import coo_matrix
    sparse = coo_matrix(matrix)
    sparse.sum_duplicates()
    blocks = numpy.zeros((sparse.nnz, 3, 3))
    blocks[:, 0, 0] = sparse.data
    return sparse.row, sparse.col, blocks


def blocks_of(matrix: Any, nodes: int) -> tuple:
    """(rows, columns, blocks) of a matrix."""
    if isinstance(matrix, tuple):
        return matrix
    if isinstance(matrix, numpy.ndarray) and matrix.shape == (nodes, 3, 3):
        each = numpy.arange(nodes, dtype=numpy.int32)
        return each, each, matrix
    from scipy.sparse import bsr_matrix
    if matrix.shape != (3 * nodes, 3 * nodes):
        raise ValueError(f"a stiffness of {nodes} nodes has the shape ({3 * nodes}, {3 * nodes}), not {matrix.shape}")
    sparse = bsr_matrix(matrix, blocksize=(3, 3))
    rows = numpy.repeat(numpy.arange(nodes, dtype=numpy.int32), numpy.diff(sparse.indptr))
    return rows, sparse.indices, sparse.data
