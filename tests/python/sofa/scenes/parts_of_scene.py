# SPDX-License-Identifier: LGPL-2.1-or-later
"""What scenes share."""


def add_solver(node, iterations=25):
    node.addObject("EulerImplicitSolver", name="ode")
    return node.addObject("CGLinearSolver", name="linear", iterations=iterations, tolerance=1e-9, threshold=1e-9)
