# SPDX-License-Identifier: LGPL-2.1-or-later
"""Hyperelastic laws written in Python: an energy in NumPy, and nothing else has to be derived."""
from typing import Any, Tuple

import numpy

from .played import ForceField

_TINY = 1e-30  # of the complex step: what is below it does not exist


def _tetrahedra(corners: numpy.ndarray) -> Tuple[numpy.ndarray, numpy.ndarray]:
    """Gradients of the shape functions (m, 1, 4, 3) and volumes (m, 1)."""
    edges = (corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1)
    inverse = numpy.linalg.inv(edges)
    gradients = numpy.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)
    return gradients[:, None], numpy.linalg.det(edges)[:, None] / 6


def _hexahedra(corners: numpy.ndarray) -> Tuple[numpy.ndarray, numpy.ndarray]:
    """The same at eight points of Gauss, (m, 8, 8, 3) and (m, 8)."""
    signs = numpy.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], float)
    points = signs / numpy.sqrt(3)
    terms = 1 + points[:, None, :] * signs[None, :, :]  # (point, node, axis)
    local = numpy.stack([signs[:, axis] * terms[:, :, (axis + 1) % 3] * terms[:, :, (axis + 2) % 3] for axis in range(3)], axis=2) / 8
    jacobian = numpy.einsum("mni,pnj->mpij", corners, local)
    return numpy.einsum("pnj,mpji->mpni", local, numpy.linalg.inv(jacobian)), numpy.linalg.det(jacobian)


class Law(ForceField):
    """Tetrahedra or hexahedra of a hyperelastic solid, whose energy per volume is density(F):

        class NeoHookean(stroma.Law):
            def density(self, F):
                return self.mu / 2 * (self.I1(F) - 3 - 2 * numpy.log(self.J(F))) + self.la / 2 * numpy.log(self.J(F)) ** 2

        node.add(NeoHookean(points, cells, mu=1e3, la=4e3), name="law")

    The stress P = dW/dF is the derivative of that by complex steps, to round-off; dP/dF are differences of P, to about 1e-9. So
    density() has to work on complex arrays: no abs(), norm() or comparisons of what depends on F. Override stress() and tangent()
    where speed matters. Tetrahedra have one point, hexahedra the eight of Gauss."""

    time_dependent = False

    def __init__(self, points: Any, cells: Any, **parameters: Any):
        super().__init__(**parameters)
        self.cells = numpy.asarray(cells)
        corners = numpy.asarray(points, float)[self.cells]
        if self.cells.ndim != 2 or self.cells.shape[1] not in (4, 8):
            raise ValueError(f"cells have the shape {self.cells.shape}: expected (m, 4), tetrahedra, or (m, 8), hexahedra")
        self._gradients, self._volumes = (_tetrahedra if self.cells.shape[1] == 4 else _hexahedra)(corners)
        if not (self._volumes > 0).all():
            raise ValueError(f"cell {int(numpy.argmin(self._volumes.min(axis=1)))} is flat or inside out at rest")

    # ---- invariants ----
    @staticmethod
    def J(F: numpy.ndarray) -> numpy.ndarray:
        """det F; quicker than numpy.linalg.det()."""
        a, b, c = F[..., 0, :], F[..., 1, :], F[..., 2, :]
        return (a[..., 0] * (b[..., 1] * c[..., 2] - b[..., 2] * c[..., 1]) + a[..., 1] * (b[..., 2] * c[..., 0] - b[..., 0] * c[..., 2]) +
                a[..., 2] * (b[..., 0] * c[..., 1] - b[..., 1] * c[..., 0]))

    @staticmethod
    def I1(F: numpy.ndarray) -> numpy.ndarray:
        """tr F^T F"""
        return numpy.einsum("...ij,...ij", F, F)

    @staticmethod
    def C(F: numpy.ndarray) -> numpy.ndarray:
        """F^T F; I4 of a fibre along a is a C a."""
        return numpy.einsum("...ki,...kj->...ij", F, F)

    # ---- the law ----
    def density(self, F: numpy.ndarray) -> numpy.ndarray:
        """W [J/m^3] for deformation gradients of shape (..., 3, 3), real or complex."""
        raise NotImplementedError

    def stress(self, F: numpy.ndarray) -> numpy.ndarray:
        """P = dW/dF, the first Piola-Kirchhoff stress [Pa], (..., 3, 3)."""
        P, moved = numpy.empty_like(F), F.astype(complex)
        for i in range(3):
            for j in range(3):
                moved[..., i, j] += 1j * _TINY
                P[..., i, j] = self.density(moved).imag / _TINY
                moved[..., i, j] = F[..., i, j]
        return P

    def tangent(self, F: numpy.ndarray) -> numpy.ndarray:
        """dP_ij / dF_kl, (..., 3, 3, 3, 3)."""
        A, h = numpy.empty(F.shape + (3, 3)), 1e-6
        for k in range(3):
            for l in range(3):
                way = numpy.zeros((3, 3))
                way[k, l] = h
                A[..., k, l] = (self.stress(F + way) - self.stress(F - way)) / (2 * h)
        return (A + numpy.einsum("...ijkl->...klij", A)) / 2

    # ---- the force ----
    def deformation(self, x: numpy.ndarray) -> numpy.ndarray:
        """F at the points of each cell, (cells, points, 3, 3)."""
        return numpy.einsum("mai,mpaj->mpij", x[self.cells], self._gradients)

    def energy(self, x):
        return float((self._volumes * self.density(self.deformation(x))).sum())

    def force(self, x, v, t):
        of_cells = -numpy.einsum("mp,mpij,mpaj->mai", self._volumes, self.stress(self.deformation(x)), self._gradients)
        total = numpy.zeros_like(x)
        numpy.add.at(total, self.cells, of_cells)
        return total

    def stiffness(self, x, v, t):
        from scipy.sparse import coo_matrix
        K = -numpy.einsum("mp,mpaj,mpijkl,mpbl->maibk", self._volumes, self._gradients, self.tangent(self.deformation(x)),
                          self._gradients, optimize=True)
        at = 3 * self.cells[:, :, None] + numpy.arange(3)
        rows, columns = numpy.broadcast_arrays(at[:, :, :, None, None], at[:, None, None, :, :])
        return coo_matrix((K.ravel(), (rows.ravel(), columns.ravel())), shape=(x.size, x.size))
