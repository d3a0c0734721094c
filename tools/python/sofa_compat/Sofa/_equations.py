# SPDX-License-Identifier: LGPL-2.1-or-later
"""The equations of the last step as SOFA's linear systems, linear solvers and constraint solvers tell them.

A x = b is the linear solve of a step for its motion: of EulerImplicitSolver x is the change of velocity. With J the gradients of the
constraints, W = s J A^-1 J^T is how impulses change them, s what positions move by for a change of velocity (dt)."""
import sys

import numpy as np

from . import _contacts
from ._objects import Object

#: modules that a scene imports for these calls: without them SOFA's objects do not have them either
_MODULES = ("Sofa.SofaLinearSystem", "Sofa.SofaLinearSolver", "Sofa.SofaConstraintSolver")
#: of a template of fewer numbers than the engine keeps: which of them it has
_COLUMNS = {"Vec2": [0, 1], "Rigid2": [0, 1, 5]}


def are_wanted():
    """A scene is to ask for the equations of its steps."""
    return any(name in sys.modules for name in _MODULES)


def asks_for_gradients(listeners):
    """A controller reads `constraint` of a state, J of the last step, which needs no module in SOFA."""
    def names(code):
        yield from code.co_names
        for each in code.co_consts:
            if hasattr(each, "co_names"):
                yield from names(each)
    return any("constraint" in names(each.__code__) for thing in listeners for kind in type(thing).__mro__ for each in vars(kind).values()
               if hasattr(each, "__code__") and not kind.__module__.startswith("Sofa"))


class ConstraintRows(str):
    """J on the nodes of a state: as text, each row its number, how many nodes it has, and of each the node and its numbers, which is
    what SOFA's Python gave; and with what the sparse matrix of today's answers."""

    def __new__(cls, matrix, width):
        lines = []
        for row in range(matrix.shape[0]):
            columns, values = (part[matrix.indptr[row]:matrix.indptr[row + 1]] for part in (matrix.indices, matrix.data))
            nodes = sorted(set((columns // width).tolist()))
            if nodes:
                dense = {node: np.zeros(width) for node in nodes}
                for column, value in zip(columns.tolist(), values.tolist()):
                    dense[column // width][column % width] = value
                lines.append(f"{row} {len(nodes)} " + " ".join(f"{node} " + " ".join(f"{each:.17g}" for each in dense[node])
                                                               for node in nodes))
        self = super().__new__(cls, "\n".join(lines))
        self.matrix, self.shape, self.dtype, self.ndim, self.nnz = matrix, matrix.shape, matrix.dtype, 2, matrix.nnz
        return self

    def toarray(self):
        return self.matrix.toarray()

    def tocsr(self):
        return self.matrix


class Solves(Object):
    """A linear solver or a linear system."""

    def A(self):
        """The matrix as a sparse one of SciPy, of states in the order of the tree; a held direction has a one on the diagonal."""
        return self._s_equations().matrix

    def b(self):
        return self._s_equations().right_side

    def x(self):
        return self._s_equations().solution

    get_system_matrix, get_rhs_vector, get_solution_vector = A, b, x

    def _s_equations(self):
        engine = self._s_engine()
        if engine is None:
            raise RuntimeError(f"{self._s_place()}: there are no equations before the scene is initialised and a step is made")
        return engine.equations(self)

    def _s_attribute(self, name):
        return None if name in ("A", "b", "x") else super()._s_attribute(name)


class ConstraintSolver(Object):
    def W(self):
        """Compliance of the constraints, of rows as `constraintForces` has them."""
        engine = self._s_engine()
        if engine is None:
            raise RuntimeError(f"{self._s_place()}: there is no W before the scene is initialised and a step is made")
        return engine.compliance(self)

    def lambda_force(self):
        return np.array(self.findData("constraintForces").value)

    def dfree(self):
        """What the rows of W() would measure after a step without these forces, to first order in how far they move: of a cable what is
        pulled in, of a cavity the growth of its volume, of tied and fixed nodes how far they are off."""
        engine = self._s_engine()
        if engine is None:
            raise RuntimeError(f"{self._s_place()}: there is no dfree before the scene is initialised and a step is made")
        compliance = self.W()
        return _measured(engine, self) - compliance @ self.lambda_force()


#: what a constraint measures, of those with a force for one condition; None: nothing, as it holds
_MEASURED = {"CableConstraint": "displacement", "SurfacePressureConstraint": "volumeGrowth", "BilateralLagrangianConstraint": None,
             "FixedLagrangianConstraint": None}


def _measured(engine, solver):
    """Of each row, after the last step."""
    found = [np.zeros(0)]
    for component, count in engine.constraint_counts():
        if count and component.type not in _MEASURED:
            raise RuntimeError(f"{solver._s_place()}: dfree() is offered for cables, cavities, tied and fixed nodes, and not for "
                               f"{component.path}, a {component.type}")
        name = _MEASURED.get(component.type)
        found.append(np.zeros(count) if name is None else np.full(count, float(component.get(name))))
    return np.concatenate(found)


class Equations:
    """Of the states below a node."""

    def __init__(self, matrix, right_side, solution, whole, gradients=None):
        self.matrix, self.right_side, self.solution, self.whole, self.gradients = matrix, right_side, solution, whole, gradients


def _states_below(engine, thing):
    """(paths of states at or below the node of a thing, or the next node above that has some)."""
    node = thing._s_node()
    while node is not None:
        top = engine.mirror.paths.get(id(node))
        inside = [path for path in engine.state_paths() if top is not None and path.startswith(top.rstrip("/") + "/")]
        if inside:
            return inside
        node = node._s_node()
    return []


def of(engine, thing, stroma):
    """The equations that a linear solver or a linear system has solved."""
    inside = _states_below(engine, thing)
    systems = [(integrator, states) for integrator, states in stroma.systems_of(engine.sim._engine)
               if any(path in inside for path, _, _ in states)]
    if len(systems) != 1:
        raise RuntimeError(f"{thing._s_place()}: is of {len(systems)} systems of equations, and answers for one: "
                           + ", ".join(integrator for integrator, _ in systems))
    integrator, states = systems[0]
    whole, right_side, solution, _ = _whole(engine, integrator, stroma)
    order = {path: number for number, path in enumerate(engine.state_paths())}
    rows = np.concatenate([_numbers_of(engine, path, first, size) for path, first, size in
                           sorted((each for each in states if each[0] in inside), key=lambda each: order[each[0]])])
    return Equations(whole[rows][:, rows], right_side[rows], solution[rows], whole)


def _whole(engine, integrator, stroma):
    """A, b, x and the projector onto the free directions, of all rows, three numbers each."""
    from scipy import sparse

    (values, columns, starts), held, right_side, solution = stroma.last_equations(engine.sim._engine, integrator)
    matrix = sparse.bsr_matrix((values, columns, starts)).tocsr()
    free = sparse.bsr_matrix((held, np.arange(len(held)), np.arange(len(held) + 1))).tocsr()
    matrix = (free @ matrix @ free + (sparse.identity(matrix.shape[0], format="csr") - free)).tocsr()
    matrix.eliminate_zeros()
    return matrix, right_side.ravel(), solution.ravel(), free


def _numbers_of(engine, path, first, size):
    """Which of the three numbers of each row a state has, in SOFA's order."""
    state = engine.sim.state(path)
    rows = 3 * np.arange(first, first + size)
    if state.kind == "points":
        found = (rows[:, None] + np.arange(3)).reshape(-1, 3)
    elif state.kind == "frames":
        found = (rows[:, None] + np.arange(3)).reshape(-1, 6)
    else:
        return rows
    columns = _COLUMNS.get(engine.plain_template_of(path))
    return (found if columns is None else found[:, columns]).ravel()


def _rows_of(engine, integrator, stroma):
    """(J of all rows of the system, three numbers each, in SOFA's rows; by how much a change of velocity moves positions)."""
    from scipy import sparse

    starts, columns, values, displacement = stroma.last_gradients(engine.sim._engine, integrator)
    rows, _ = stroma.rows_of_states(engine.sim._engine, integrator)
    gradients = sparse.csr_matrix((values, columns, starts), shape=(len(starts) - 1, 3 * rows))
    parts, first = [], 0
    for component, count in engine.constraint_counts():
        part = gradients[first:first + count]
        parts.append(_turned(engine, component, part) if component.type == "CollisionResponse" else part)
        first += count
    if first != gradients.shape[0]:
        raise RuntimeError(f"{integrator}: of constraints with several conditions for one force no rows are told: {gradients.shape[0]} "
                           f"conditions, {first} forces")
    return (sparse.vstack(parts).tocsr() if parts else gradients), displacement


def _turned(engine, response, gradients):
    """Rows of contacts along SOFA's tangents in the place of the engine's."""
    from scipy import sparse

    normals = response.get("normals")
    if gradients.shape[0] != 3 * len(normals):
        return gradients  # without friction
    sign = np.where(_contacts.turned_round(response, engine.types()), -1.0, 1.0)
    first, second = _contacts.tangents(sign[:, None] * normals)
    blocks = []
    for number, normal in enumerate(normals):
        along = gradients[3 * number:3 * number + 3].toarray().reshape(3, -1, 3)
        near = [row for row in np.flatnonzero(along[0].any(axis=1)) if np.linalg.norm(np.cross(along[0, row], normal)) < 1e-9]
        size = along[0, near[0]] @ normal
        own = along[1:, near[0]] / size
        block = np.zeros((3, 3))
        block[0, 0] = 1
        block[1:, 1:] = sign[number] * np.stack([first[number], second[number]]) @ own.T
        blocks.append(block)
    return sparse.block_diag(blocks, format="csr") @ gradients if blocks else gradients


def constraint_of(engine, path, stroma):
    """J of the last step on the nodes of a state."""
    from scipy import sparse

    for integrator in engine.integrators_of_constraints():
        _, states = stroma.rows_of_states(engine.sim._engine, integrator)
        for name, first, size in states:
            if name == path:
                gradients, _ = _rows_of(engine, integrator, stroma)
                numbers = _numbers_of(engine, path, first, size)
                state = engine.sim.state(path)
                return ConstraintRows(gradients[:, numbers].tocsr(), len(numbers) // state.nodes)
    return ConstraintRows(sparse.csr_matrix((0, 0)), 3)


def compliance(engine, solver, stroma):
    """W of all systems together: what no constraint joins is zero."""
    from scipy import sparse
    from scipy.sparse import linalg

    blocks = []
    for integrator in engine.integrators_of_constraints():
        gradients, displacement = _rows_of(engine, integrator, stroma)
        matrix, _, _, free = _whole(engine, integrator, stroma)
        own = (gradients[:, :matrix.shape[0]] @ free).tocsr()
        if own.shape[0]:
            blocks.append(displacement * (own @ (free @ _answers(engine, integrator, matrix, own.T.toarray(), linalg, stroma))))
    return sparse.block_diag(blocks).toarray() if blocks else np.zeros((0, 0))


def _answers(engine, integrator, matrix, pushes, linalg, stroma):
    """What pushes, a column each, change velocities by: A^-1, and of nodes that answer by themselves their own compliance."""
    _, states = stroma.rows_of_states(engine.sim._engine, integrator)
    places = {path: _numbers_of(engine, path, first, size) for path, first, size in states}
    alone = [(places[path], _own_compliance(engine, path, component, thing)) for path, component, thing in engine.uncoupled()
             if path in places and places[path].max(initial=-1) < matrix.shape[0]]
    rest = np.array(pushes)
    for numbers, _ in alone:
        rest[numbers] = 0
    answers = linalg.splu(matrix.tocsc()).solve(rest)
    for numbers, compliance in alone:
        width = compliance.shape[1]
        answers[numbers] = np.einsum("nij,njc->nic", compliance, pushes[numbers].reshape(-1, width, pushes.shape[1])).reshape(len(numbers), -1)
    return answers


def _given_compliance(component, thing, nodes, has_frames):
    """Of each node, or of all frames 7 numbers; None: that of its mass."""
    given, default = np.ravel(component.get("compliance")), component.get("defaultCompliance")
    data = thing._s_data.get("defaultCompliance")
    has_default = data is not None and data._s_raw is not None
    if has_frames:
        return given if given.size == 7 else np.array([default, 1, 0, 0, 1, 0, 1]) if has_default else None
    if given.size == nodes:
        return given
    return np.full(nodes, default if has_default or not given.size else given[0])


def _own_compliance(engine, path, component, thing):
    """Shape (nodes, width, width)."""
    state = engine.sim.state(path)
    has_frames = state.kind == "frames"
    given = _given_compliance(component, thing, state.nodes, has_frames)
    if not has_frames:
        return given[:, None, None] * np.eye(3 if state.kind == "points" else state.x.shape[1])
    if given is None:
        if path not in engine.inertias:
            raise RuntimeError(f"{thing._s_place()}: W() is not offered where masses follow frames that answer by themselves, without a "
                               "compliance of 7 numbers")
        return np.linalg.inv(engine.inertias[path])
    c, xx, xy, xz, yy, yz, zz = given
    one = np.zeros((6, 6))
    one[:3, :3], one[3:, 3:] = c * np.eye(3), [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    return np.tile(one, (state.nodes, 1, 1))


def inertias(engine):
    """Of frames whose masses say how they answer by themselves, (nodes, 6, 6), where a step begins."""
    found = {}
    for path, component, thing in engine.uncoupled():
        state = engine.sim.state(path)
        if state.kind != "frames" or _given_compliance(component, thing, state.nodes, True) is not None:
            continue
        node = path.rpartition("/")[0]
        masses = [each for each in engine._components.values() if each.role == "mass"]
        if all(each.path.rpartition("/")[0] == node or not each.path.startswith(node + "/") for each in masses):
            whole = sum(engine.sim.matrix_of(each).toarray() for each in masses if each.path.rpartition("/")[0] == node)
            found[path] = np.stack([whole[6 * i:6 * i + 6, 6 * i:6 * i + 6] for i in range(state.nodes)])
    return found
