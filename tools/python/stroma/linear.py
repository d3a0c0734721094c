# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the matrices of a scene give: directions that are free, modes of vibration, derivatives of an equilibrium."""
from typing import TYPE_CHECKING, Any, Dict, Iterable, List, NamedTuple, Tuple

import numpy

from .errors import StromaError, refusal
from .tree import caller

if TYPE_CHECKING:
    from .simulation import Simulation

_STILL = 1e-4  # of the size of the body: a step of Newton's method that is longer has left no equilibrium
_ILL = 1e12
_UNEVEN = 1e-3  # of a shape: what the part of dF/dx that is not symmetric may change; frequencies change by the square
_SINGULAR = "something in the scene moves freely, which no stiffness holds: its equilibrium has no derivative"
_ENTRIES = 200  # of arrays of parameters: each costs two forces


class Modes(NamedTuple):
    """Modes of vibration about the present state."""

    frequencies: numpy.ndarray  #: (count,) [Hz], the lowest first; below zero: a shape that grows, as of a body that buckles
    shapes: numpy.ndarray  #: (count, rows, 3): of the rows of force(); shape i has the modal mass 1: u M u = 1


class Gradient(NamedTuple):
    """The derivative of a number J(x) of an equilibrium x."""

    parameters: Dict[str, Any]  #: by what was asked for: a number, or an array as the attribute has it
    forces: numpy.ndarray  #: (rows, 3): by a force on each node, unit of J per newton


def free_directions(held: Any) -> Any:
    """T, (3 rows, directions), of the matrix I - P of what is held: T^T T = I and T T^T = P. Nodes that constraints join are
    looked at together."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import connected_components
    rows = held.shape[0] // 3
    pattern = csr_matrix((numpy.ones(len(held.indices)), held.indices, held.indptr), shape=(rows, rows))
    count, group = connected_components(pattern, directed=False)
    order, sizes = numpy.argsort(group, kind="stable"), numpy.bincount(group, minlength=count)
    whole = held.tocsr()
    places: List[numpy.ndarray] = []
    values: List[numpy.ndarray] = []
    for members in numpy.split(order, numpy.cumsum(sizes)[:-1]):
        numbers = (3 * members[:, None] + numpy.arange(3)).ravel()
        part = whole[numbers][:, numbers].toarray() if held.nnz else numpy.zeros((len(numbers),) * 2)
        if not (part - numpy.diag(part.diagonal())).any():  # axes are free or held
            chosen = numpy.flatnonzero(part.diagonal() < 0.5)
            directions = numpy.eye(len(numbers))[:, chosen]
        else:
            size, vectors = numpy.linalg.eigh((part + part.T) / 2)
            directions = vectors[:, size < 0.5]
        for column in directions.T:
            places.append(numbers[column != 0])
            values.append(column[column != 0])
    starts = numpy.concatenate([[0], numpy.cumsum([len(each) for each in places])]).astype(int)
    flat = numpy.concatenate(places) if places else numpy.zeros(0, int)
    return csr_matrix((numpy.concatenate(values) if values else numpy.zeros(0), flat, starts), shape=(len(places), 3 * rows)).T.tocsr()


def modes_of(simulation: "Simulation", count: int, integrator: str) -> Modes:
    """The lowest solutions of -K u = (2 pi f)^2 M u in the free directions, with K = dF/dx, the geometric stiffness included."""
    from scipy.sparse.linalg import LinearOperator, eigsh
    T = simulation.free_directions(integrator)
    size = T.shape[1]
    if not 0 < count < size:
        raise ValueError(f"{count} modes of a body with {size} free directions: expected 1 to {size - 1}")
    present = _Forces(simulation, integrator)
    M = (T.T @ simulation.matrix("mass", constrained=True, integrator=integrator) @ T).tocsc()
    if not M.diagonal().sum() > 0:
        raise StromaError("nothing that is free has a mass: there are no modes")
    whole = (T.T @ present.stiffness() @ T).tocsc()
    K, uneven = (whole + whole.T) / 2, (whole - whole.T) / 2
    shift, factors = _below_all(K, M)
    squares, vectors = eigsh(-K, count, M, sigma=shift, which="LM", OPinv=LinearOperator(K.shape, factors.solve),
                             v0=numpy.random.default_rng(0).normal(size=size))  # the same shapes from each call
    order = numpy.argsort(squares)
    squares, vectors = squares[order], vectors[:, order]
    turned = factors.solve(uneven @ vectors)  # how the rest of dF/dx changes the shapes, in the first order
    if not numpy.sqrt((turned * (M @ turned)).sum(axis=0)).max() <= _UNEVEN:
        raise StromaError("the stiffness is not symmetric: its modes are no vibrations. scipy.sparse.linalg.eigs takes matrix() as it is")
    vectors = vectors * numpy.sign(vectors[abs(vectors).argmax(axis=0), numpy.arange(count)])
    frequencies = numpy.sign(squares) * numpy.sqrt(abs(squares)) / (2 * numpy.pi)
    return Modes(frequencies, numpy.ascontiguousarray((T @ vectors).T).reshape(count, -1, 3))


def _below_all(K: Any, M: Any) -> Tuple[float, Any]:
    """A shift below every solution of -K u = s M u, so that those nearest to it are the lowest, and the factors of -K - shift M.
    It starts a little below zero, where the matrix of a body that moves freely can be factorised."""
    from scipy.sparse.linalg import splu
    shift = -1e-6 * (abs(K.diagonal()).sum() / M.diagonal().sum() or 1.0)
    for _ in range(30):
        try:
            factors = splu((-K - shift * M).tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
            # without exchanged rows, positive pivots say that the matrix is positive definite
            if (factors.U.diagonal() > 0).all() and (factors.perm_r == factors.perm_c).all():
                return shift, factors
        except RuntimeError:  # a pivot of zero
            pass
        shift *= 10
    raise StromaError("the lowest mode is not found: some free directions have no mass, and the stiffness does not hold them")


class _Forces:
    """A copy of a simulation whose forces F(x) are differentiated in the free directions T."""

    def __init__(self, simulation: "Simulation", integrator: str):
        self.copy = simulation.copy()
        self.integrator = integrator
        self.T = simulation.free_directions(integrator)
        self.rows = simulation.rows(integrator)
        self.states = {path: self.copy.state(path) for path in self.rows}
        self.start = {path: numpy.array(state.x) for path, state in self.states.items()}
        self.size = max(float(numpy.ptp(x[:, :3], axis=0).max()) for x in self.start.values()) or 1.0
        self.matrix = simulation.matrix("stiffness", constrained=True, integrator=integrator)

    def stiffness(self) -> Any:
        """dF/dx, (3 rows, 3 rows)."""
        of_points = all(state.kind == "points" for state in self.states.values())
        return self._derivative(self.matrix) if of_points else self.matrix

    def force(self) -> numpy.ndarray:
        return self.copy.force(self.integrator)

    def _slope(self, direction: numpy.ndarray) -> numpy.ndarray:
        """dF/dx times a direction, (rows, 3), by central differences."""
        h = 1e-6 * self.size / max(abs(direction).max(), 1e-300)
        forces = []
        for side in (h, -h):
            self._put(side * direction)
            forces.append(self.force())
        self._put(numpy.zeros_like(direction))
        return (forces[0] - forces[1]) / (2 * h)

    def _put(self, change: numpy.ndarray) -> None:
        """Moves the nodes from where they started. Constraints that tie nodes of two states average them whenever one state is set,
        so that all states are set again until nothing moves: each pass leaves a quarter of what is missing."""
        before: Dict[str, numpy.ndarray] = {}
        for _ in range(60):
            for path, rows in self.rows.items():
                self.states[path].set(x=self.start[path] + change[rows])
            now = {path: numpy.array(self.states[path].x) for path in self.rows}
            if len(now) == 1 or before and max(abs(x - before[path]).max() for path, x in now.items()) <= 1e-15 * self.size:
                return
            before = now

    def _is_derivative(self, K: Any) -> bool:
        random = numpy.random.default_rng(0).normal(size=self.T.shape[1])
        slope, product = self.T.T @ self._slope((self.T @ random).reshape(-1, 3)).ravel(), self.T.T @ (K @ (self.T @ random))
        return bool(numpy.linalg.norm(slope - product) <= 1e-6 * numpy.linalg.norm(product))

    def _derivative(self, K: Any) -> Any:
        """K where it is dF/dx. The matrix of some methods, as of turned elements, leaves terms out, and dF/dx is not symmetric: it is
        then taken by differences, of all nodes at once that act on no node in common."""
        from scipy.sparse import csr_matrix
        if self._is_derivative(K):
            return K
        count = K.shape[0] // 3
        pattern = csr_matrix((numpy.ones(len(K.indices), numpy.int32), K.indices, K.indptr), shape=(count, count))
        free = abs(self.T).sum(axis=1).A.ravel().reshape(-1, 3) > 0
        acts_on = pattern.tocsc()
        rows, columns, values = [], [], []
        for nodes in _colours_of([acts_on.indices[acts_on.indptr[i]:acts_on.indptr[i + 1]].tolist() for i in range(count)]):
            for axis in range(3):
                chosen = nodes[free[nodes, axis]]
                if not len(chosen):
                    continue
                direction = numpy.zeros((count, 3))
                direction[chosen, axis] = 1
                slope = self._slope(direction)
                for node in chosen:
                    to = acts_on.indices[acts_on.indptr[node]:acts_on.indptr[node + 1]]
                    rows.append((3 * to[:, None] + numpy.arange(3)).ravel())
                    columns.append(numpy.full(3 * len(to), 3 * node + axis))
                    values.append(slope[to].ravel())
        found = csr_matrix((numpy.concatenate(values), (numpy.concatenate(rows), numpy.concatenate(columns))), shape=K.shape)
        if not self._is_derivative(found):
            raise StromaError("the derivative of the forces is not found: nodes act on others that their stiffness does not know")
        return found


class _Equilibrium(_Forces):
    """A copy of a simulation at an equilibrium x, F(x, p) = 0 in the free directions T, with the factors of T^T dF/dx T."""

    def __init__(self, simulation: "Simulation", integrator: str):
        from scipy.sparse.linalg import splu
        super().__init__(simulation, integrator)
        self.present = self.force()
        reduced = (self.T.T @ self.stiffness() @ self.T).tocsc()
        try:
            self.factors = splu(reduced)
        except RuntimeError:  # an exact zero
            raise StromaError(_SINGULAR) from None
        # the longest step that a force causes, relative to its size and that of K: of a body that moves freely round-off decides
        random = numpy.random.default_rng(1).normal(size=reduced.shape[0])
        if not numpy.linalg.norm(self.factors.solve(random)) * abs(reduced).max() < _ILL * numpy.linalg.norm(random):
            raise StromaError(_SINGULAR)

    def difference(self, attribute: str, value: Any, change: Any) -> numpy.ndarray:
        """T^T dF/dp times the change of a value p."""
        forces = []
        for way in (change, -change):
            self.copy.set(attribute, value + way)
            forces.append(self.force())
        self.copy.set(attribute, value)
        first, second = forces[0] - forces[1], forces[0] + forces[1] - 2 * self.present
        size = numpy.linalg.norm(second)
        if size > 0.5 * numpy.linalg.norm(first) and size > 1e-6 * numpy.linalg.norm(self.present):
            raise StromaError(f"the force jumps at the present value of {attribute}, where a method takes another way: there is no derivative (expected a value "
                              "a little beside it)")
        return self.T.T @ first.ravel() / 2


def gradient_of(simulation: "Simulation", of: Any, parameters: Iterable[str], step: float, integrator: str) -> Gradient:
    """By the adjoint: K^T a = dJ/dx, then dJ/dp = -a . dF/dp. Two forces for each number of a parameter, one solve for all."""
    import warnings

    from .errors import SceneWarning
    if not 0 < step < numpy.inf:
        raise ValueError(f"differences with a step of {step}: expected a positive fraction of the parameter, as 1e-4")
    asked = [parameters] if isinstance(parameters, str) else list(parameters)
    present = _Equilibrium(simulation, integrator)
    right = numpy.array(of, float)
    count = present.T.shape[0] // 3
    if right.shape != (count, 3):
        raise ValueError(f"dJ/dx has the shape {right.shape}: expected ({count}, 3), the rows of force()")
    missing = present.factors.solve(present.T.T @ present.present.ravel())
    if not abs(missing).max() <= _STILL * present.size:
        warnings.warn(f"this is no equilibrium: a step of Newton's method moves it by {abs(missing).max() / present.size:.2g} of its size. A "
                      "gradient is that of a shape at rest under its load, as a StaticSolver finds it", SceneWarning, stacklevel=3)
    adjoint = present.factors.solve(present.T.T @ right.ravel(), "T")
    found: Dict[str, Any] = {}
    for name in asked:
        found[name] = _by_parameter(simulation, present, adjoint, name, step)
    return Gradient(found, (-(present.T @ adjoint)).reshape(-1, 3))


def _by_parameter(simulation: "Simulation", present: _Equilibrium, adjoint: numpy.ndarray, name: str, step: float) -> Any:
    path, _, attribute = name.rpartition(".")
    of_gravity = name.strip("/.") == "gravity"
    if not path and not of_gravity:
        raise refusal(f"'{name}' names no attribute", "a path and an attribute, as /liver/fem.youngModulus", where=caller())
    value = numpy.asarray(simulation.gravity if of_gravity else simulation.component(path).get(attribute))
    if value.dtype.kind not in "fiu":
        raise ValueError(f"{name} is no number: there is no derivative by it")
    value = value.astype(float)
    cells = _cells_of(simulation, path, value.size) if value.ndim == 1 and value.size > 1 and not of_gravity else None
    if cells is not None:
        return _by_cells(present, adjoint, name, value, cells, step)
    if value.size > _ENTRIES:
        raise ValueError(f"{name} has {value.size} numbers, as many as no kind of cell of the mesh has, and each costs two forces: expected "
                         f"{_ENTRIES} or fewer")
    out = numpy.zeros(value.shape)
    for index in numpy.ndindex(value.shape):
        change = numpy.zeros(value.shape)
        change[index] = step * (abs(value[index]) or 1.0)
        out[index] = -adjoint @ present.difference(name, value, change) / change[index]
    return out if out.size > 1 else float(out.ravel()[0])


def _cells_of(simulation: "Simulation", path: str, count: int) -> Any:
    """The nodes of as many cells as an attribute of a component has numbers, as rows of force(); None where it has none."""
    folder, rows = path.rpartition("/")[0], simulation.rows()
    for state in simulation.states():
        mesh = state.mesh() if state.path.rpartition("/")[0] == folder and state.path in rows and state.kind == "points" else None
        for cells in mesh.cells.values() if mesh is not None else ():
            if len(cells) == count:
                return cells + rows[state.path].start
    return None


def _colours_of(cells: List[List[int]]) -> List[numpy.ndarray]:
    """Lists of cells, by their numbers, of which no two share a node."""
    used: Dict[int, int] = {}  # of each node: a bit for each colour
    lists: List[List[int]] = []
    for number, nodes in enumerate(cells):
        taken = 0
        for node in nodes:
            taken |= used.get(node, 0)
        colour = (~taken & (taken + 1)).bit_length() - 1  # the lowest bit that is free
        for node in nodes:
            used[node] = used.get(node, 0) | 1 << colour
        if colour == len(lists):
            lists.append([])
        lists[colour].append(number)
    return [numpy.array(each) for each in lists]


def _by_cells(present: _Equilibrium, adjoint: numpy.ndarray, name: str, value: numpy.ndarray, cells: numpy.ndarray, step: float) -> Any:
    """Cells of one colour change together: the force on the nodes of each comes from it alone."""
    h = step * numpy.where(value != 0, abs(value), abs(value).max() or 1.0)
    way, out = present.T @ adjoint, numpy.zeros(len(value))
    for chosen in _colours_of(cells.tolist()):
        change = numpy.zeros(len(value))
        change[chosen] = h[chosen]
        work = (way * (present.T @ present.difference(name, value, change))).reshape(-1, 3).sum(axis=1)
        out[chosen] = -work[cells[chosen]].sum(axis=1) / h[chosen]
    random = h * numpy.random.default_rng(0).uniform(0.2, 1.0, len(value))
    together = -adjoint @ present.difference(name, value, random)
    if not abs(together - out @ random) <= 1e-5 * (abs(out) @ random) + 1e-300:
        raise StromaError(f"{name}: a number of one cell acts on nodes of others too; there is no derivative by each of them")
    return out
