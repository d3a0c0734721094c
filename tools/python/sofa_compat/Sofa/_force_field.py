# SPDX-License-Identifier: LGPL-2.1-or-later
"""Force fields that a scene writes in SOFA's way, as the engine calls them."""
import numpy as np
import stroma

from . import _messages

_PROBED = 300  # columns of a stiffness that are found one by one
tells = []  # what a command that steps by itself says of an error in a force: it ends the step, whose forces have no value then


class Rows(np.ndarray):
    """What addForce() gets as data: rows of a state, read and written as data are, or as arrays."""

    def __new__(cls, array):
        return np.asarray(array).view(cls)

    @property
    def value(self):
        return np.asarray(self)

    def array(self):
        return np.asarray(self)

    def writeableArray(self, *_):
        return self

    writeable = writeableArray

    def __enter__(self):
        return np.asarray(self)

    def __exit__(self, *_):
        return False


def told(thing, call, *values):
    """What a method of a scene gives. A command that steps by itself tells of an error, and gets None."""
    try:
        return call(*values)
    except Exception as error:
        if not tells:
            raise
        tells[0](error, _place(thing, error))
        return None


def _place(thing, error):
    """Of a method that takes other values than SOFA gives."""
    for name in ("addForce", "addDForce", "addKToMatrix", "apply", "applyJ", "applyJT"):
        code = getattr(getattr(type(thing), name, None), "__code__", None)
        if f"{name}()" in str(error) and code is not None:
            return code.co_filename, code.co_firstlineno
    return None


class _Explicit(stroma.ForceField):
    """Without a derivative."""

    time_dependent = True
    has_forced = False  #: addForce() has been called

    def __init__(self, field):
        super().__init__(field=field)

    def _parameters(self, t):
        return {"kFactor": 1.0, "bFactor": 0.0, "mFactor": 0.0, "time": t, "dt": self.field.getRoot().getDt()}

    def force(self, x, v, t):
        out = told(self.field, self._force, x, v, t)
        return np.full_like(v, np.nan) if out is None else out

    def _force(self, x, v, t):
        out = np.zeros_like(v)
        self.has_forced = True
        self.field.addForce(self._parameters(t), Rows(out), Rows(np.array(x)), Rows(np.array(v)))
        return out


class _Implicit(_Explicit):
    symmetric = True  # as SOFA takes it for every solver
    exact_tangent = False
    has_matrix = True
    is_apart = None  # whether addDForce() couples no nodes; None: not known

    def stiffness(self, x, v, t):
        matrix = told(self.field, self._stiffness, x, v, t)
        return np.full((v.size, v.size), np.nan) if matrix is None else matrix

    def _stiffness(self, x, v, t):
        field, size = self.field, v.size
        if not self.has_forced:  # what addForce() keeps for its derivative
            self._force(x, v, t)
        given = field.addKToMatrix(self._parameters(t), len(v), v.shape[1]) if self.has_matrix else None
        if given is not None:
            given = np.asarray(given, float)
            if given.shape == (size, size, 1):
                return given[:, :, 0]
            if given.shape == (size, size) and (size > 3 or np.allclose(given, given.T)):
                return given  # else, of one node, three rows of (row, column, value)
            if given.size % 3:
                raise ValueError(f"addKToMatrix() gives neither a matrix of {size} rows nor rows of (row, column, value)")
            from scipy import sparse

            rows, columns, values = given.reshape(-1, 3).T
            for each in (rows, columns):
                for number in each[(each != np.floor(each)) | (each < 0) | (each >= size)][:1]:
                    raise ValueError(f"addKToMatrix() names row or column {number:g} of a matrix of {size}, whose first one is 0")
            return sparse.coo_matrix((values, (rows.astype(int), columns.astype(int))), shape=(size, size))
        return self._by_products(v, t)

    def _product(self, way, t):
        """K p, by addDForce()."""
        out = np.zeros_like(way)
        if _takes_four(self.field):
            self.field.addDForce(Rows(out), Rows(np.array(way)), self._parameters(t), 0.0)
        else:
            self.field.addDForce(self._parameters(t), Rows(out), Rows(np.array(way)))
        return out

    def _by_products(self, x, t):
        """A block for each node where each moves alone, as in most forces that scenes write. Else a column for each number."""
        if type(self.field).addDForce is _base().addDForce:
            return _nothing(x)
        if self.is_apart is not False and x.shape[1] == 3:
            blocks = self._blocks(x, t)
            if blocks is not None:
                self.is_apart = True
                return blocks
            if self.is_apart and x.size > _PROBED:
                raise ValueError(f"addDForce() couples nodes, and did not before: addKToMatrix() gives the derivative of {len(x)} nodes")
        if self.is_apart is not False:
            self.is_apart = False
            if x.size > _PROBED:
                _messages.warn(f"{self.field._s_place()}: addDForce() is not used for {len(x)} nodes that it couples, and the force is that "
                               "at the start of each step: addKToMatrix() gives the derivative as a matrix")
        if x.size > _PROBED:
            return _nothing(x)
        return np.stack([self._product(unit.reshape(x.shape), t).ravel() for unit in np.eye(x.size)], axis=1)

    def _blocks(self, x, t):
        """None: a node feels the way of another one, which the product with any way tells."""
        blocks = np.stack([self._product(np.tile(axis, (len(x), 1)), t) for axis in np.eye(3)], axis=2)
        way = np.random.default_rng(0).normal(size=x.shape)
        expected, found = np.einsum("nij,nj->ni", blocks, way), self._product(way, t)
        return None if np.abs(found - expected).max() > 1e-9 * np.abs(found).max() else blocks


def _nothing(rows):
    """A matrix of zeros."""
    from scipy import sparse

    return np.zeros((len(rows), 3, 3)) if rows.shape[1] == 3 else sparse.csr_matrix((rows.size, rows.size))


def _base():
    from ._objects import ForceField

    return ForceField


def _takes_four(field):
    """Both orders are found in scenes: (df, dx, parameters, bFactor) and (parameters, df, dx)."""
    code = getattr(type(field).addDForce, "__code__", None)
    return code is not None and code.co_argcount >= 5


def _takes_too_few(method):
    """Of (self, parameters, nodes, numbers of one): SOFA calls it where a matrix is assembled alone, so that many a scene never finds out."""
    code = getattr(method, "__code__", None)
    return code is not None and code.co_argcount < 4 and not code.co_flags & 4


def played(field, nodes):
    """The object that the engine calls for a force field of the scene."""
    kind, base = type(field), _base()
    has_product = kind.addDForce is not base.addDForce
    has_matrix = kind.addKToMatrix is not base.addKToMatrix
    if has_matrix and has_product and _takes_too_few(kind.addKToMatrix):
        has_matrix = False
        _messages.warn(f"{field._s_place()}: addKToMatrix() is not called: it takes {kind.addKToMatrix.__code__.co_argcount} arguments "
                       "and not four (self, parameters, nodes, numbers). addDForce() is")
    if has_matrix or has_product:
        made = _Implicit(field)
        made.has_matrix = has_matrix
        return made
    return _Explicit(field)
