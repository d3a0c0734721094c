# SPDX-License-Identifier: LGPL-2.1-or-later
"""Integrator and linear solver."""
from Sofa import _libraries

_libraries.same_module(__name__, "defaultsolver")


def DefaultSolver(node, iterative=True):
    node.addObject("EulerImplicitSolver", name="TimeIntegrationSchema")
    if iterative:
        return node.addObject("CGLinearSolver", name="LinearSolver")
    return node.addObject("SparseLDLSolver", name="LinearSolver", template="CompressedRowSparseMatrixd")
