# SPDX-License-Identifier: LGPL-2.1-or-later
"""The equations of the last step as SOFA's linear systems, linear solvers and constraint solvers tell them.

A x = b is the linear solve of a step for its motion: of EulerImplicitSolver x is the change of velocity. With J the gradients of the
constraints, W = s J A^-1 J^T is how impulses change them, s what positions move by for a change of velocity (dt)."""
import sys

import numpy as np

from ._objects import Object

#: modules that a scene imports for these calls: without them SOFA's objects do not have them either
_MODULES = ("Sofa.SofaLinearSystem", "Sofa.SofaLinearSolver", "Sofa.SofaConstraintSolver")
#: of a template of fewer numbers than the engine keeps: which of them it has
_COLUMNS = {"Vec2": [0, 1], "Rigid2": [0, 1, 5]}


def are_wanted():
    """A scene is to ask for the equations of its steps."""
    return any(name in sys.modules for name in _MODULES)


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
        raise AttributeError(f"{self._s_place()}: dfree() is not offered: what cables and cavities are asked for is a part of their "
                             "conditions here. W() and lambda_force() are there")


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
    whole, right_side, solution = _whole(engine, integrator, stroma)
    order = {path: number for number, path in enumerate(engine.state_paths())}
    rows = np.concatenate([_numbers_of(engine, path, first, size) for path, first, size in
                           sorted((each for each in states if each[0] in inside), key=lambda each: order[each[0]])])
    return Equations(whole[rows][:, rows], right_side[rows], solution[rows], whole)


def _whole(engine, integrator, stroma):
    """A, b and x of all rows, three numbers each."""
    from scipy import sparse

    (values, columns, starts), held, right_side, solution = stroma.last_equations(engine.sim._engine, integrator)
    matrix = sparse.bsr_matrix((values, columns, starts)).tocsr()
    free = sparse.bsr_matrix((held, np.arange(len(held)), np.arange(len(held) + 1))).tocsr()
    matrix = (free @ matrix @ free + (sparse.identity(matrix.shape[0], format="csr") - free)).tocsr()
    matrix.eliminate_zeros()
    return matrix, right_side.ravel(), solution.ravel()


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


def compliance(engine, solver, stroma):
    """W of all systems together: what no constraint joins is zero."""
    from scipy import sparse
    from scipy.sparse import linalg

    blocks = []
    for integrator in engine.integrators_of_constraints():
        starts, columns, values, displacement = stroma.last_gradients(engine.sim._engine, integrator)
        matrix = _whole(engine, integrator, stroma)[0]
        gradients = sparse.csr_matrix((values, columns, starts), shape=(len(starts) - 1, matrix.shape[0]))
        if gradients.shape[0]:
            answers = linalg.splu(matrix.tocsc()).solve(gradients.T.toarray())
            blocks.append(displacement * (gradients @ answers))
    found = sparse.block_diag(blocks).toarray() if blocks else np.zeros((0, 0))
    forces = len(engine.constraint_forces())
    if len(found) != forces:
        raise RuntimeError(f"{solver._s_place()}: W() is not offered of constraints with several conditions for one force: "
                           f"{len(found)} conditions, {forces} forces")
    return found
