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


class _Explicit(stroma.ForceField):
    """Without a derivative."""

    time_dependent = True

    def __init__(self, field):
        super().__init__(field=field)

    def _parameters(self, t):
        return {"kFactor": 1.0, "bFactor": 0.0, "mFactor": 0.0, "time": t, "dt": self.field.getRoot().getDt()}

    def _asked(self, call, *values):
        try:
            return call(*values)
        except Exception as error:
            if not tells:
                raise
            tells[0](error, self._place(error))
            return None

    def _place(self, error):
        """Of a method that takes other values than SOFA gives."""
        for name in ("addForce", "addDForce", "addKToMatrix"):
            code = getattr(getattr(type(self.field), name, None), "__code__", None)
            if f"{name}()" in str(error) and code is not None:
                return code.co_filename, code.co_firstlineno
        return None

    def force(self, x, v, t):
        out = self._asked(self._force, x, v, t)
        return np.full_like(x, np.nan) if out is None else out

    def _force(self, x, v, t):
        out = np.zeros_like(x)
        self.field.addForce(self._parameters(t), Rows(out), Rows(np.array(x)), Rows(np.array(v)))
        return out


class _Implicit(_Explicit):
    symmetric = True  # as SOFA takes it for every solver
    exact_tangent = False
    has_matrix = True

    def stiffness(self, x, v, t):
        matrix = self._asked(self._stiffness, x, v, t)
        return np.full((x.size, x.size), np.nan) if matrix is None else matrix

    def _stiffness(self, x, v, t):
        field, size = self.field, x.size
        given = field.addKToMatrix(self._parameters(t), len(x), x.shape[1]) if self.has_matrix else None
        if given is not None:
            given = np.asarray(given, float)
            if given.shape == (size, size, 1):
                return given[:, :, 0]
            if given.shape == (size, size) and (size > 3 or np.allclose(given, given.T)):
                return given  # else, of one node, three rows of (row, column, value)
            if given.size % 3:
                raise ValueError(f"addKToMatrix() gives neither a matrix of {size} rows nor rows of (row, column, value)")
            matrix = np.zeros((size, size))
            for row, column, value in given.reshape(-1, 3):
                matrix[int(row), int(column)] += value
            return matrix
        matrix = np.zeros((size, size))
        for column in range(size if type(field).addDForce is not _base().addDForce else 0):
            unit, out = np.zeros(size), np.zeros_like(x)
            unit[column] = 1
            field.addDForce(Rows(out), Rows(unit.reshape(x.shape)), self._parameters(t), 0.0) if _takes_four(field) else \
                field.addDForce(self._parameters(t), Rows(out), Rows(unit.reshape(x.shape)))
            matrix[:, column] = out.ravel()
        return matrix


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
    if has_matrix or (has_product and 3 * nodes <= _PROBED):
        made = _Implicit(field)
        made.has_matrix = has_matrix
        return made
    if has_product:
        _messages.warn(f"{field._s_place()}: addDForce() is not used for {nodes} nodes, and the force is that at the start of each "
                       "step: addKToMatrix() gives the derivative as a matrix")
    return _Explicit(field)
