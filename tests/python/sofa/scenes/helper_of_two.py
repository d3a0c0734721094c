# SPDX-License-Identifier: LGPL-2.1-or-later
# Written in Python 2, for python_two.py.


def solvers(node):
    print "the solvers of", node.name
    for name in {'EulerImplicitSolver': 1}.iterkeys():
        node.createObject(name)
    node.createObject('CGLinearSolver', iterations=10, tolerance=1e-14, threshold=1e-14)
