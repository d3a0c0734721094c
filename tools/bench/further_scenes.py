# SPDX-License-Identifier: LGPL-2.1-or-later
"""Six scenes of solver_choice.py, the set `further`: kinds that none of the other sets has. They were written after the estimates had
been measured anew, without a look at what is chosen for them, and only measured. SI units."""
import math

from scene_parts import EULER, NOWHERE, STATIC, bent, body, grid, hexas, law, moved_end, newton, quadratics, root, tets, unheld

T = "tetrahedra"


def horn(u, v, w):
    turn, r = .8 * math.pi * (1 - u), .06 + .02 * v * (1 - .5 * u)
    return r * math.cos(turn), r * math.sin(turn), .05 * u + .02 * w * (1 - .5 * u)


def four_bodies():
    return "".join(body(grid((11, 9, 9), (.06, .05, .05), (0, .1 * i, 0)), tets(young, .4, "svd"), "", T, solver="")
                   .replace('name="body"', f'name="body{i}"') for i, young in enumerate((1e4, 3e4, 9e4, 2.7e5)))


def mat():
    bed = ('<BoxROI name="under" box="-1 -1 -1 1 1 0.0001" position="@dofs.rest_position"/>'
           '<RestShapeSpringsForceField name="bed" points="@under.indices" stiffness="3"/>')
    push = ('<BoxROI name="top" box="0.05 0.05 0.0299 0.09 0.09 1" position="@dofs.rest_position"/>'
            '<ConstantForceField indices="@top.indices" totalForce="0 0 -3"/>')
    return unheld(body(grid((35, 30, 6), (.2, .17, .03)), hexas(4e4, .45, "svd"), STATIC, wall=NOWHERE, more=bed + push))


def drawn():
    field = ('<HexahedronHyperelasticityFEMForceField name="fem" materialName="NeoHookean" youngModulus="5e4" poissonRatio="0.49" '
             'dilatation="mean"/>')
    return body(grid((25, 12, 12), (.12, .05, .05)), field, STATIC, more=moved_end(0.1199, "0 5", "0 0 0  0.03 0.01 0"))


def further():
    yield ("horn", "tapered horn of tetrahedra, Mooney-Rivlin, `BDFOdeSolver`, 3,510 nodes", 20,
           root(body(bent((39, 10, 9), horn), law("MooneyRivlin", 'youngModulus="5e4" poissonRatio="0.42" c2="1000"'),
                     '<BDFOdeSolver name="solver" order="2"/>', T, wall="-1 -0.0001 -1 1 0.0001 1"), .015))
    yield "four", "four bodies of one solver, 1:27, Newton's method, 3,564 nodes", 15, root(newton(1e-5) + "@SOLVER@" + four_bodies(), .02)
    yield "mat", "statics: mat of hexahedra on a bed of springs, `svd`, 6,300 nodes", 1, root(mat(), 1)
    yield ("whip", "rod of tetrahedra, `polar`, trapezoidal rule, 80 short steps, 2,205 nodes", 80,
           root(body(grid((45, 7, 7), (.3, .02, .02)), tets(5e6, .35, "polar"),
                     '<EulerImplicitSolver name="solver" trapezoidalScheme="true"/>', T), .001))
    block = quadratics("9 7 7", "0.1 0.07 0.07", EULER, "3e5", 0.4, "small")
    yield "quadratic_linear", "quadratic tetrahedra, `small`, 40 steps", 40, root(block, .01)
    yield "drawn", "statics in five steps: neo-Hookean hexahedra, Poisson's ratio 0.49, 3,600 nodes", 5, root(drawn(), 1)
