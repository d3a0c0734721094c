# SPDX-License-Identifier: LGPL-2.1-or-later
"""Ten scenes of solver_choice.py, the set `mixed`: kinds that none of the other sets has. They were written after the rules for
springs in hexahedra had been mended, without a look at the estimates, and only measured. SI units."""
from scene_parts import (EULER, NOWHERE, STATIC, bent, body, grid, hexas, inside, law, moved_end, newton, quadratics, root, sheet, tets,
                         unheld)

T, H = "tetrahedra", "hexahedra"
NEWMARK = '<NewmarkImplicitSolver name="solver"/>'


def tied_beams():
    """A needle of beams in a block of tetrahedra, tied to it by springs at ten points of its own."""
    places = [(.011 * k, .035, .0251) for k in range(10)]
    points = "  ".join(f"{x:.3f} {y} {z}" for x, y, z in places)
    springs = "  ".join(f"{k} {k} 4000 0 0" for k in range(10))
    beams = ('<Node name="needle"><RegularGridTopology name="line" n="41 1 1" min="-0.02 0.035 0.0251" max="0.14 0.035 0.0251"/>'
             '<MechanicalObject name="dofs" template="Rigid3"/><UniformMass vertexMass="2e-5" inertia="1e-9 1e-9 1e-9"/>'
             '<FixedProjectiveConstraint indices="0"/><BeamFEMForceField name="fem" radius="0.0008" youngModulus="2e9" '
             f'poissonRatio="0.3"/><Node name="ties"><MechanicalObject name="points" position="{points}"/>'
             '<BeamLinearMapping/></Node></Node>')
    marked = f'<Node name="ties"><MechanicalObject name="points" position="{points}"/><BarycentricMapping input="@../dofs"/></Node>'
    block = body(grid((17, 11, 9), (.1, .07, .05)), tets(2e4, .44, "svd"), "", T, solver="", more=marked)
    return (EULER + "@SOLVER@" + block + beams + '<SpringForceField name="tie" object1="@body/ties/points" '
            f'object2="@needle/ties/points" spring="{springs}"/>')


def fluid():
    return ('<HexahedronPorousForceField name="fluid" fluidFraction="0.7" bulkModulus="4e4" limitModulus="1e7" permeability="1e-12" '
            'coupling="implicit" drainedIndices="@top.indices"/><BoxROI name="top" box="-1 -1 0.0199 1 1 1" '
            'position="@dofs.rest_position"/>')


def landing_hexahedra():
    falls = unheld(body(grid((15, 11, 9), (.07, .05, .04), (-.035, -.025, .003)), hexas(4e4, .42, "svd"), "", H, wall=NOWHERE,
                        solver=""))
    return (newton(1e-4, 40) + "@SOLVER@" + falls + '<BarrierContact name="contact" mstate="@body/dofs" topology="@body/grid" '
            'contactDistance="0.002" planes="0 0.1 1 0" friction="0.2" slipVelocity="2e-3" selfContact="false"/>')


def cloth():
    return sheet().replace("</Node>", '<BoxROI name="patch" box="0.25 0.05 -1 0.35 0.15 1" position="@dofs.rest_position"/>'
                           '<RestShapeSpringsForceField name="pad" points="@patch.indices" stiffness="0.5"/></Node>')


def two_bodies():
    soft = body(grid((19, 10, 10), (.1, .05, .05)), tets(4e3, .45, "svd"), "", T, solver="").replace('"body"', '"soft"')
    stiff = body(grid((19, 10, 10), (.1, .05, .05), (0, .1, 0)), tets(4e6, .3, "svd"), "", T, solver="").replace('"body"', '"stiff"')
    return EULER + "@SOLVER@" + soft + stiff


def wobbly(u, v, w):
    return (.16 * u, .05 * v + .01 * u * u, .03 * w + .004 * v)


def mixed():
    yield "tied_beams", "needle of beams in tetrahedra, tied by springs, `svd`, 1,683 nodes", 40, root(tied_beams(), .01)
    wet = body(grid((13, 13, 11), (.03, .03, .02)), law("NeoHookean", 'youngModulus="3e4" poissonRatio="0.2"').replace("Tetrahedron", "Hexahedron"),
               newton(1e-5), wall="-1 -1 -1 1 1 1e-6", more=fluid())
    yield "wet", "porous: hexahedra, Newton's method, 1,859 nodes", 15, root(wet, .05, "0 0 -40")
    yield "landing_hexahedra", "contact: hexahedra that slide on a slope, `svd`, 1,485 nodes", 25, root(landing_hexahedra(), .005, "0 0 -9.81")
    yield "cloth", "membrane with springs of bending and springs to the ground, 1,326 nodes", 40, root(cloth(), .01, "0 0 -9.81")
    yield "contrast", "two bodies of one solver, 1:1,000, `svd`, 3,800 nodes", 20, root(two_bodies(), .01)
    yield ("slab_trapezoidal", "slab of tetrahedra, StVenant-Kirchhoff, trapezoidal rule, Newton's method, 3,456 nodes", 15,
           root(body(grid((24, 24, 6), (.15, .15, .025)), law("StVenantKirchhoff", 'youngModulus="8e4" poissonRatio="0.4"'),
                     newton(1e-6).replace("name=", 'trapezoidalScheme="true" name='), cells=T), .02))
    arm = quadratics("22 5 5", "0.2 0.035 0.035", newton(1e-6), "9e4", 0.45)
    yield "quadratic_arm", "slender quadratic tetrahedra, `svd`, Newton's method, 3,483 nodes", 12, root(arm, .015)
    moved = moved_end(0.1199, "0 0.1 0.3", "0 0 0  0.01 0.03 0  -0.01 0.02 0.02")
    yield ("shaken", "hexahedra whose end is moved, `polar`, Newmark's rule, 3,375 nodes", 30,
           root(body(grid((27, 13, 13), (.12, .06, .06)), hexas(6e4, .43, "polar"), NEWMARK, more=moved), .01))
    bone = inside("-1 0.02 0.012 0.13 0.034 0.024", T, 3e6, .3, "svd", T)
    yield ("bone", "statics: bent limb with a bone, tetrahedra, `svd`, 3,990 nodes", 1,
           root(body(bent((38, 15, 7), wobbly), tets(3e4, .46, "svd"), STATIC, cells=T, more=bone), 1))
    yield ("damped", "Rayleigh damping, tetrahedra, `svd`, long steps, 5,184 nodes", 12,
           root(body(grid((36, 12, 12), (.2, .06, .06)), tets(1e5, .47, "svd"),
                     '<EulerImplicitSolver name="solver" rayleighStiffness="0.02" rayleighMass="0.5"/>', T), .05))
