#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""A law of one's own in NumPy: tetrahedra of a neo-Hookean solid, W = mu/2 (I1 - 3 - 2 ln J) + lambda/2 (ln J)^2, its force and
its exact stiffness, beside the law of the engine. Slow, and open to any change. Run it with: python3 scenes/python/own_law.py"""
import numpy
import stroma
from scipy.sparse import coo_matrix


class NeoHookean(stroma.ForceField):
    """P = mu (F - F^-T) + lambda ln(J) F^-T; the gradient of the shape functions in `g`, the volumes in `volume`."""

    def __init__(self, rest, cells, young, poisson):
        self.cells = numpy.asarray(cells)
        self.mu, self.la = young / (2 * (1 + poisson)), young * poisson / ((1 + poisson) * (1 - 2 * poisson))
        edges = (rest[self.cells[:, 1:]] - rest[self.cells[:, :1]]).transpose(0, 2, 1)
        inverse = numpy.linalg.inv(edges)
        self.volume = numpy.linalg.det(edges) / 6
        self.g = numpy.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)  # (m, 4, 3)

    def deformation(self, x):
        F = numpy.einsum("eai,eaj->eij", x[self.cells], self.g)
        return F, numpy.linalg.inv(F).transpose(0, 2, 1), numpy.log(numpy.linalg.det(F))

    def energy(self, x):
        F, _, log = self.deformation(x)
        return float(self.volume @ (self.mu / 2 * ((F ** 2).sum(axis=(1, 2)) - 3 - 2 * log) + self.la / 2 * log ** 2))

    def force(self, x, v, t):
        F, inverse, log = self.deformation(x)
        P = self.mu * (F - inverse) + self.la * log[:, None, None] * inverse
        of_cells = -numpy.einsum("e,eij,eaj->eai", self.volume, P, self.g)
        total = numpy.zeros_like(x)
        numpy.add.at(total, self.cells, of_cells)
        return total

    def stiffness(self, x, v, t):
        _, inverse, log = self.deformation(x)
        h = numpy.einsum("eij,eaj->eai", inverse, self.g)  # F^-T g
        K = self.mu * numpy.einsum("eaj,ebj,ik->eaibk", self.g, self.g, numpy.eye(3))
        K += numpy.einsum("e,eak,ebi->eaibk", self.mu - self.la * log, h, h) + self.la * numpy.einsum("eai,ebk->eaibk", h, h)
        K *= -self.volume[:, None, None, None, None]
        at = 3 * self.cells[:, :, None] + numpy.arange(3)
        rows, columns = numpy.broadcast_arrays(at[:, :, :, None, None], at[:, None, None, :, :])
        return coo_matrix((K.ravel(), (rows.ravel(), columns.ravel())), shape=(x.size, x.size))


def scene(field):
    root = stroma.Node("root", dt=0.02, gravity=(0, -9.81, 0))
    root.add("EulerImplicitSolver", newtonIterations=5)
    root.add("SparseLDLSolver")
    root.add("RegularGridTopology", name="grid", n=(7, 3, 3), min=(0, 0, 0), max=(0.12, 0.04, 0.04))
    cells = root.add_child("cells")
    root.add("MechanicalObject", name="dofs")
    root.add("UniformMass", totalMass=0.2)
    root.add("BoxROI", name="end", box=(-0.001, -1, -1, 0.001, 1, 1))
    root.add("FixedProjectiveConstraint", indices="@end.indices")
    cells.add("TetrahedronSetTopologyContainer", name="tetrahedra")
    cells.add("Hexa2TetraTopologicalMapping", input="@../grid", output="@tetrahedra")
    field(root, cells)
    return root


def mine(root, cells):
    root.add(NeoHookean(root["grid"].position, cells["tetrahedra"].tetrahedra, young=8000, poisson=0.4), name="law")


def theirs(_, cells):
    cells.add("TetrahedronHyperelasticityFEMForceField", mstate="@../dofs", materialName="NeoHookean", youngModulus=8000, poissonRatio=0.4)


one, other = stroma.load(scene(mine)), stroma.load(scene(theirs))
for simulation in (one, other):
    simulation.run(25)
tips = [simulation.state().x[:, 1].min() for simulation in (one, other)]
print(f"the tip is at y = {tips[0] * 1000:.4f} mm with the law in NumPy, {tips[1] * 1000:.4f} mm with that of the engine")


def check():
    law = NeoHookean(one.state().start, one["/cells/tetrahedra"].tetrahedra, young=8000, poisson=0.4)
    assert max(law.check(one.state().x).values()) < 1e-6, "its force and its stiffness are the derivatives"
    assert tips[0] < -0.005 and abs(tips[0] - tips[1]) < 1e-8
