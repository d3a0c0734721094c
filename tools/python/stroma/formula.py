# SPDX-License-Identifier: LGPL-2.1-or-later
"""Hyperelastic laws by a formula: its derivatives are computed along with it, to round-off."""
import ast
import operator
import warnings
from typing import Any, Callable, Dict, List, Optional

import numpy

from .errors import refusal
from .laws import Law
from .tree import caller
from .types import nearest


class Jet:
    """A value with its first and second derivatives by n variables: v (...), d (n, ...), dd (n, n, ...)."""

    __array_ufunc__ = None  # arrays leave sums and products to it

    def __init__(self, v: Any, d: Any, dd: Any):
        self.v, self.d, self.dd = v, d, dd

    def through(self, f: Any, slope: Any, bend: Any) -> "Jet":
        """f(self), of which f, f' and f'' are given at this value."""
        return Jet(f, slope * self.d, slope * self.dd + bend * (self.d[:, None] * self.d[None, :]))

    def __add__(self, other: Any) -> "Jet":
        if not isinstance(other, Jet):
            return Jet(self.v + other, self.d, self.dd)
        return Jet(self.v + other.v, self.d + other.d, self.dd + other.dd)

    __radd__ = __add__

    def __neg__(self) -> "Jet":
        return Jet(-self.v, -self.d, -self.dd)

    def __pos__(self) -> "Jet":
        return self

    def __sub__(self, other: Any) -> "Jet":
        return self + (-other)

    def __rsub__(self, other: Any) -> "Jet":
        return -self + other

    def __mul__(self, other: Any) -> "Jet":
        if not isinstance(other, Jet):
            return Jet(self.v * other, self.d * other, self.dd * other)
        mixed = self.d[:, None] * other.d[None, :]
        return Jet(self.v * other.v, self.v * other.d + other.v * self.d,
                   self.v * other.dd + other.v * self.dd + mixed + mixed.swapaxes(0, 1))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> "Jet":
        return self * (other ** -1 if isinstance(other, Jet) else 1 / other)

    def __rtruediv__(self, other: Any) -> "Jet":
        return self ** -1 * other

    def __pow__(self, power: Any) -> "Jet":
        if isinstance(power, Jet):
            return exp(power * log(self))
        if power == 2:  # without a power of zero that is none
            return self * self
        return self.through(self.v ** power, power * self.v ** (power - 1), power * (power - 1) * self.v ** (power - 2))

    def __rpow__(self, base: Any) -> "Jet":
        return exp(self * numpy.log(base))


def _function(f: Callable, slope: Callable, bend: Callable) -> Callable:
    def of(x: Any) -> Any:
        return x.through(f(x.v), slope(x.v), bend(x.v)) if isinstance(x, Jet) else f(x)
    return of


exp = _function(numpy.exp, numpy.exp, numpy.exp)
log = _function(numpy.log, lambda x: 1 / x, lambda x: -1 / x ** 2)
FUNCTIONS = {
    "exp": exp, "log": log, "ln": log,
    "sqrt": _function(numpy.sqrt, lambda x: 0.5 / numpy.sqrt(x), lambda x: -0.25 / x ** 1.5),
    "sin": _function(numpy.sin, numpy.cos, lambda x: -numpy.sin(x)),
    "cos": _function(numpy.cos, lambda x: -numpy.sin(x), lambda x: -numpy.cos(x)),
    "sinh": _function(numpy.sinh, numpy.cosh, numpy.sinh), "cosh": _function(numpy.cosh, numpy.sinh, numpy.cosh),
    "tanh": _function(numpy.tanh, lambda x: 1 / numpy.cosh(x) ** 2, lambda x: -2 * numpy.tanh(x) / numpy.cosh(x) ** 2),
    #: x where it is positive, else zero: fibres that only pull
    "positive": _function(lambda x: numpy.maximum(x, 0), lambda x: (x > 0) * 1.0, lambda x: 0 * x),
}
_OPERATORS = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
              ast.Pow: operator.pow, ast.USub: operator.neg, ast.UAdd: operator.pos}


class Formula:
    """An expression of names, numbers, + - * / ^ and functions, evaluated on whatever the names stand for."""

    def __init__(self, text: str, names: Any):
        self.text, self.names = text, set()
        try:
            self._tree = ast.parse(text.strip().replace("^", "**"), mode="eval").body
        except SyntaxError as error:
            raise refusal(f"the formula '{text}' cannot be read: {error.msg} at character {error.offset}", where=caller()) from None
        self._check(self._tree, set(names))

    def _check(self, node: ast.AST, known: set) -> None:
        if isinstance(node, ast.Name):
            if node.id not in known:
                raise refusal(f"the formula '{self.text}' has '{node.id}', which is neither an invariant nor a parameter",
                              ", ".join(sorted(known)), nearest(node.id, sorted(known)), caller())
            self.names.add(node.id)
            return
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and len(node.args) == 1 and not node.keywords:
            if node.func.id not in FUNCTIONS:
                raise refusal(f"the formula '{self.text}' has no function '{node.func.id}'", ", ".join(sorted(FUNCTIONS)),
                              nearest(node.func.id, sorted(FUNCTIONS)), caller())
            return self._check(node.args[0], known)
        is_number = isinstance(node, ast.Constant) and isinstance(node.value, (int, float)) and not isinstance(node.value, bool)
        operation = getattr(node, "op", None)
        if not is_number and type(operation) not in _OPERATORS:
            raise refusal(f"the formula '{self.text}' has what is none: {ast.unparse(node)}",
                          "names, numbers, + - * / ^ and functions of one", where=caller())
        for child in (getattr(node, part, None) for part in ("left", "right", "operand")):
            if child is not None:
                self._check(child, known)
        return None

    def at(self, values: Dict[str, Any]) -> Any:
        return self._at(self._tree, values)

    def _at(self, node: ast.AST, values: Dict[str, Any]) -> Any:
        if isinstance(node, ast.Name):
            return values[node.id]
        if isinstance(node, ast.Constant):
            return node.value
        if isinstance(node, ast.Call):
            return FUNCTIONS[node.func.id](self._at(node.args[0], values))
        if isinstance(node, ast.UnaryOp):
            return _OPERATORS[type(node.op)](self._at(node.operand, values))
        return _OPERATORS[type(node.op)](self._at(node.left, values), self._at(node.right, values))


_DERIVED = {"I1bar": ("I1", -2 / 3), "I2bar": ("I2", -4 / 3), "I4bar": ("I4", -2 / 3)}
_ONE = numpy.eye(3)


class FormulaLaw(Law):
    """Tetrahedra or hexahedra whose energy per volume [J/m^3] is a formula:

        law = stroma.FormulaLaw(points, cells, "mu/2 * (I1bar - 3) + K/2 * (J - 1)^2", mu=1e3, K=1e4)

    of J = det F, the invariants I1 and I2 of C = F^T F, I4 = a C a of a fibre `a` (one for all cells, or one for each), the same of
    J^(-2/3) C as I1bar, I2bar and I4bar, and parameters: numbers, or one for each cell. Stress and tangent are its derivatives, to
    round-off: the formula is evaluated once, with them. Functions: exp, log, sqrt, sin, cos, sinh, cosh, tanh, positive."""

    def __init__(self, points: Any, cells: Any, energy: str, fibre: Optional[Any] = None, **parameters: Any):
        super().__init__(points, cells)
        self._fibre = None
        if fibre is not None:
            fibre = numpy.asarray(fibre, float)
            self._fibre = (fibre / numpy.linalg.norm(fibre, axis=-1, keepdims=True)).reshape(-1, 1, 3)
        invariants = ["J", "I1", "I2"] + (["I4"] if fibre is not None else [])
        taken = set(invariants) | {name for name, (base, _) in _DERIVED.items() if base in invariants}
        wrong = [name for name in parameters if name in taken or name in FUNCTIONS]
        if wrong:
            raise refusal(f"a parameter is called {wrong[0]}, which the formula knows already", where=caller())
        self._parameters = {name: self._spread(name, value) for name, value in parameters.items()}
        self._formula = Formula(energy, taken | set(parameters))
        self._invariants: List[str] = [name for name in invariants if name in self._formula.names or name == "J" or any(
            each in self._formula.names and base == name for each, (base, _) in _DERIVED.items())]
        at_rest = self.stress(numpy.broadcast_to(_ONE, self._volumes.shape + (3, 3)).copy())
        size = abs(self.tangent(numpy.broadcast_to(_ONE, self._volumes.shape + (3, 3)).copy())).max()
        if not abs(at_rest).max() <= 1e-9 * size:
            warnings.warn(f"the law '{energy}' has a stress at rest, {abs(at_rest).max():.3g} Pa: the body will not keep its shape",
                          stacklevel=2)

    def _spread(self, name: str, value: Any) -> Any:
        value = numpy.asarray(value, float)
        if value.ndim == 0:
            return float(value)
        if value.shape != (len(self.cells),):
            raise ValueError(f"{name} has the shape {value.shape}: expected a number, or one for each of {len(self.cells)} cells")
        return value[:, None]

    def _values(self, F: numpy.ndarray) -> Dict[str, Any]:
        C = self.C(F)
        I1 = numpy.einsum("...ii", C)
        found = {"J": self.J(F), "I1": I1, "I2": (I1 ** 2 - numpy.einsum("...ij,...ij", C, C)) / 2}
        if self._fibre is not None:
            found["I4"] = numpy.einsum("...i,...ij,...j", self._fibre, C, self._fibre)
        return found

    def _evaluate(self, values: Dict[str, Any]) -> Any:
        for name, (base, power) in _DERIVED.items():
            if name in self._formula.names:
                values[name] = values[base] * values["J"] ** power
        return self._formula.at({**values, **self._parameters})

    def density(self, F: numpy.ndarray) -> numpy.ndarray:
        return self._evaluate(self._values(F)) + numpy.zeros(F.shape[:-2])

    def _jet(self, F: numpy.ndarray) -> Jet:
        values, names = self._values(F), self._invariants
        shape = F.shape[:-2]
        jets = {}
        for index, name in enumerate(names):
            d = numpy.zeros((len(names),) + shape)
            d[index] = 1
            jets[name] = Jet(values[name], d, numpy.zeros((len(names), len(names)) + shape))
        found = self._evaluate(jets)
        if isinstance(found, Jet):
            return found
        return Jet(found, numpy.zeros((len(names),) + shape), numpy.zeros((len(names),) * 2 + shape))

    def _slopes(self, F: numpy.ndarray) -> List[numpy.ndarray]:
        """dI/dF of each invariant."""
        found = {"J": self._cofactor(F), "I1": 2 * F}
        if "I2" in self._invariants:
            C = self.C(F)
            found["I2"] = 2 * (numpy.einsum("...ii", C)[..., None, None] * F - F @ C)
        if "I4" in self._invariants:
            a = numpy.broadcast_to(self._fibre, F.shape[:-1])
            found["I4"] = 2 * (F @ a[..., None]) * a[..., None, :]
        return [found[name] for name in self._invariants]

    @staticmethod
    def _cofactor(F: numpy.ndarray) -> numpy.ndarray:
        a, b, c = F[..., 0, :], F[..., 1, :], F[..., 2, :]
        return numpy.stack([numpy.cross(b, c), numpy.cross(c, a), numpy.cross(a, b)], axis=-2)

    def stress(self, F: numpy.ndarray) -> numpy.ndarray:
        jet = self._jet(F)
        return sum(slope * way[..., None, None] for slope, way in zip(self._slopes(F), jet.d))

    def _bend(self, name: str, F: numpy.ndarray) -> numpy.ndarray:
        """d2I/dF2, (..., 3, 3, 3, 3)."""
        if name == "J":
            return numpy.einsum("ikm,jln,...mn->...ijkl", _LEVI_CIVITA, _LEVI_CIVITA, F)
        if name == "I1":
            return 2 * numpy.einsum("ik,jl->ijkl", _ONE, _ONE)
        if name == "I4":
            return 2 * numpy.einsum("ik,...j,...l->...ijkl", _ONE, self._fibre, self._fibre)
        C, B = self.C(F), F @ F.swapaxes(-1, -2)
        I1 = numpy.einsum("...ii", C)
        return (4 * numpy.einsum("...ij,...kl->...ijkl", F, F) + 2 * numpy.einsum("...,ik,jl->...ijkl", I1, _ONE, _ONE)
                - 2 * (numpy.einsum("ik,...lj->...ijkl", _ONE, C) + numpy.einsum("...il,...kj->...ijkl", F, F)
                       + numpy.einsum("...ik,jl->...ijkl", B, _ONE)))

    def tangent(self, F: numpy.ndarray) -> numpy.ndarray:
        jet, slopes = self._jet(F), self._slopes(F)
        total = sum(self._bend(name, F) * way[..., None, None, None, None] for name, way in zip(self._invariants, jet.d))
        for i, one in enumerate(slopes):
            mixed = sum(jet.dd[i, j][..., None, None] * other for j, other in enumerate(slopes))
            total = total + one[..., :, :, None, None] * mixed[..., None, None, :, :]
        return total


_LEVI_CIVITA = numpy.zeros((3, 3, 3))
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    _LEVI_CIVITA[_i, _j, _k], _LEVI_CIVITA[_i, _k, _j] = 1, -1
