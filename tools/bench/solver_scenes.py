# SPDX-License-Identifier: LGPL-2.1-or-later
"""The scenes of solver_choice.py. `standing`: those that the estimates of a solver's time were made with. `fresh`: those that were
written afterwards, without a look at the estimates, and were looked at when these were mended. `late`: those that were written
after that; two mends came from looking at their first results. `held`: those that were written next; rules were mended by what they
had shown. `unseen`: those that were written after that, and only measured. `mixed`, `further`, `users`,
`blind`: see mixed_scenes.py, further_scenes.py, user_scenes.py and blind_scenes.py. SI units."""
import math
import os
import re

from blind_scenes import blind
from further_scenes import further
from mixed_scenes import mixed
from scene_parts import (EULER, ROOT, STATIC, Scene, bent, body, cable, grid, held, hexas, inside, law, loaded, membrane, moved_end,
                         newton, numbers, quadratics, root, sheet, tets)
from user_scenes import users


def standing():
    t, h = "tetrahedra", "hexahedra"
    soft = tets(3e4, .45, "svd")
    yield "cube_small_short", "cube, `svd`, 729 nodes", 60, root(body(grid((9, 9, 9), (.1, .1, .1)), soft, cells=t), .005)
    yield ("cube_small_long", "the same, stiffer, long steps", 40,
           root(body(grid((9, 9, 9), (.1, .1, .1)), tets(3e5, .45, "svd"), cells=t), .04))
    yield "cube_short", "cube, `svd`, 4,913 nodes", 30, root(body(grid((17, 17, 17), (.1, .1, .1)), soft, cells=t), .005)
    yield ("cube_long", "the same, stiffer, long steps", 20,
           root(body(grid((17, 17, 17), (.1, .1, .1)), tets(3e6, .3, "svd"), cells=t), .04))
    yield ("cube_linear", "cube, `small`, 3,375 nodes", 60,
           root(body(grid((15, 15, 15), (.1, .1, .1)), tets(3e5, .3, "small"), cells=t), .02))
    yield ("cube_large", "cube, `large`, 17,576 nodes, long steps", 8,
           root(body(grid((26, 26, 26), (.1, .1, .1)), tets(3e6, .3, "large"), cells=t), .2))
    yield ("catheter", "catheter, `svd`, Newton's method, 3,775 nodes", 6,
           root(body(grid((151, 5, 5), (.75, .01, .01)), tets(1e8, .4, "svd"), newton(1e-8, 30), cells=t), .02))
    yield ("catheter_large", "catheter, `large`, 3,025 nodes", 15,
           root(body(grid((121, 5, 5), (.6, .01, .01)), tets(1e8, .4, "large"), cells=t), .02))
    pulled = cable([(.01 + .0125 * i, .019, .01) for i in range(8)], "-0.01 0.024 0.01", 'valueType="displacement" value="0.01"')
    yield ("finger", "finger with a cable, `large`, 7,381 nodes", 12,
           root(body(grid((61, 11, 11), (.12, .02, .02)), tets(6e5, .4, "large"), cells=t, more=pulled), .02))
    yield "polar", "hexahedra, `polar`, 4,913 nodes", 15, root(body(grid((17, 17, 17), (.1, .1, .1)), hexas(3e5, .4, "polar")), .02)
    yield ("incompressible", "hexahedra, Poisson's ratio 0.4999, 2,744 nodes", 20,
           root(body(grid((14, 14, 14), (.08, .08, .08)), hexas(15e3, .4999, "svd", 'dilatation="mean"')), .01))
    yield ("venant", "St. Venant-Kirchhoff, Newton's method, 3,375 nodes", 15,
           root(body(grid((15, 15, 15), (.1, .1, .1)), law("StVenantKirchhoff", 'ParameterSet="10000 40000"'), newton(),
                     cells=t), .02))
    yield ("neo", "neo-Hookean, Newton's method, 2,541 nodes", 10,
           root(body(grid((21, 11, 11), (.2, .1, .1)), law("NeoHookean", 'ParameterSet="100000 400000"'), newton(), cells=t), .05))
    yield ("core", "stiff core in soft hexahedra, `polar`, 4,225 nodes", 12,
           root(body(grid((25, 13, 13), (.2, .1, .1)), hexas(2e4, .45, "polar"),
                     more=inside("-1 0.03 0.03 1 0.071 0.071", "grid", 2e8, .3, "polar", h)), .01))
    yield ("bar", "bar of hexahedra, `large`, 6,561 nodes", 15,
           root(body(grid((81, 9, 9), (.8, .08, .08)), hexas(2e6, .3, "large")), .03))
    yield ("plate", "plate of tetrahedra, `svd`, 6,724 nodes", 12,
           root(body(grid((41, 41, 4), (.4, .4, .03)), tets(1e6, .35, "svd"), cells=t), .03))
    yield ("limb", "limb with a bone, Newton's method, 9,633 nodes", 10,
           root(body(grid((57, 13, 13), (.5, .1, .1)), soft, newton(1e-5), cells=t,
                     more=inside("-1 0.04 0.04 1 0.061 0.061", "tetrahedra", 1e8, .3, "svd", t)), .02))
    drawn = cable([(.01 + .02 * i, .038, .02) for i in range(8)], "-0.01 0.045 0.02", 'valueType="force" value="5"')
    yield ("arm", "arm with a cable, `svd`, 3,321 nodes", 12,
           root(body(grid((41, 9, 9), (.2, .04, .04)), tets(2e5, .4, "svd"), cells=t, more=drawn), .05))
    yield ("rod", "rod of hexahedra, `small`, 3,276 nodes", 20,
           root(body(grid((91, 6, 6), (.45, .025, .025)), hexas(1e7, .35, "small")), .015))
    yield ("slab", "slab of tetrahedra, `large`, 4,495 nodes", 15,
           root(body(grid((31, 29, 5), (.3, .28, .04)), tets(8e4, .42, "large"), cells=t), .02))
    yield ("static_cube", "statics: cube, `svd`, 3,360 nodes", 1,
           root(body(grid((15, 14, 16), (.1, .09, .11)), tets(2e5, .4, "svd"), STATIC, cells=t), 1))
    yield ("static_slab", "statics: slab of hexahedra, `large`, 5,175 nodes", 1,
           root(body(grid((45, 23, 5), (.4, .2, .04)), hexas(5e5, .3, "large"), STATIC), 1))
    yield ("static_bar", "statics: bar, `small`, 9,849 nodes", 1,
           root(body(grid((201, 7, 7), (1, .03, .03)), tets(1e7, .35, "small"), STATIC, cells=t), 1))


def contact():
    tool = open(os.path.join(ROOT, "scenes", "examples", "contact_tool.xml")).read()
    tip = re.search(r'<Node name="tip">.*?</Node>', tool, re.S).group(0)
    soft = body(grid((25, 21, 9), (.12, .1, .04), (-.06, -.05, -.04)), tets(2e4, .45, "svd"), "", "tetrahedra",
                wall="-1 -1 -0.0401 1 1 -0.0399", solver="")
    return root(f'{newton(1e-4, 40)}@SOLVER@{soft}<Node name="tool">'
                '<MechanicalObject name="frame" template="Rigid3" position="0.01 0 0.0165 0 0 0 1"/>'
                '<UniformMass totalMass="0.05" inertia="1e-5 1e-5 1e-5"/>'
                '<LinearMovementProjectiveConstraint name="hand" indices="0" '
                'keyTimes="0 0.2 0.4" outside="hold" movements="0 0 0 0 0 0  0 0 -0.007 0 0 0  -0.006 0.003 -0.007 0 0 0.1"/>'
                f'{tip}</Node><BarrierContact name="contact" mstate="@body/dofs" topology="@body/tetrahedra" '
                'other="@tool/tip/dofs" '
                'contactDistance="0.003" friction="0.2" slipVelocity="2e-3" selfContact="false"/>', .02, "0 0 -9.81")


def between_frames():
    n, length, width = (49, 7, 7), .4, .06
    sides = [(j * width / 6, k * width / 6) for k in range(7) for j in range(7)]
    points = [(-.03, y - .03, z - .03) for y, z in sides] + [(.03, y - .03, z - .03) for y, z in sides]
    points = [(-p[0], p[1], p[2]) for p in points]
    ends = [49 * m for m in range(49)] + [49 * m + 48 for m in range(49)]
    glue = (f'<SpringForceField name="glue" object1="@dofs" object2="@../frames/points/dofs" lengths="0" '
            f'stiffness="4000" damping="2" '
            f'springsIndices1="{" ".join(map(str, ends))}" springsIndices2="{" ".join(map(str, range(98)))}"/>')
    beam = body(grid(n, (length, width, width)), hexas(8e4, .42, "polar"), "", wall="-9 -9 -9 -8 -8 -8", more=glue, solver="")
    beam = beam.replace(held("-9 -9 -9 -8 -8 -8"), "")
    return root('<EulerImplicitSolver name="solver" rayleighStiffness="0.005"/>@SOLVER@<Node name="frames">'
                '<MechanicalObject name="frames" template="Rigid3" position="-0.03 0.03 0.03 0 0 0 1 0.43 0.03 0.03 0 0 0 1"/>'
                '<UniformMass vertexMass="0.2" inertia="0.0003 0.0005 0.0006"/><FixedProjectiveConstraint indices="0"/>'
                f'<Node name="points"><MechanicalObject name="dofs" position="{numbers(c for p in points for c in p)}"/>'
                f'<RigidMapping name="mapping" rigidIndexPerPoint="{" ".join(["0"] * 49 + ["1"] * 49)}"/></Node></Node>'
                + beam, .01)


def leg():
    labels = (loaded("leg") + '<ValuesFromLabels name="stiffness" labels="@loader.tetrahedraGroups" table="1 2e4 2 2e7 3 2e7"/>'
              '<ValuesFromLabels name="compression" labels="@loader.tetrahedraGroups" table="1 0.45 2 0.3 3 0.3"/>')
    push = ('<SphereROI name="calf" centers="0 -0.060 0.235" radii="0.020"/>'
            '<ConstantForceField name="push" indices="@calf.indices" totalForce="0 2 0"/>')
    return root(body(labels, tets("@stiffness.values", "@compression.values", "svd"), STATIC, density=1060,
                     wall="-0.030 -0.015 0.320 0.016 0.032 0.346  -0.026 -0.016 0.018 0.030 0.026 0.040", more=push), 1)


def organ():
    return root(body(loaded("organ_5000"), law("StableNeoHookean", 'youngModulus="8000" poissonRatio="0.46"'), newton(1e-5), density=1060,
                     wall="-1 0.03 -1 1 1 1"), .02)


def quadratic():
    return root(quadratics("14 7 6", "0.2 0.08 0.06", newton(1e-5), "9e4", 0.44), .02)


def fresh():
    def arch(u, v, w):
        turn, r = math.pi * u, .1 + .025 * v
        return -r * math.cos(turn), r * math.sin(turn), .03 * w

    def cone(u, v, w):
        r = 1 - .6 * u
        return .2 * u, .03 * r * (2 * v - 1) * (1 + .3 * math.sin(3 * u)), .03 * r * (2 * w - 1)

    t = "tetrahedra"
    yield ("arch", "arch of hexahedra, `polar`, 3,843 nodes", 20,
           root(body(bent((61, 9, 7), arch), hexas(2e5, .4, "polar"), wall="-1 -1 -1 1 0.0001 1"), .02))
    yield ("dice", "block of tetrahedra, `large`, 336 nodes, 300 steps", 300,
           root(body(grid((7, 6, 8), (.06, .05, .07)), tets(2e4, .45, "large"), cells=t), .01))
    yield "organ", "organ, stable neo-Hookean, Newton's method, 1,400 nodes", 30, organ()
    yield "leg", "statics: leg with bones 1:1,000, `svd`", 1, leg()
    yield "quadratic", "quadratic tetrahedra, `svd`, Newton's method, 3,861 nodes", 8, quadratic()
    yield ("block", "block of 975,560 tetrahedra, `svd`, 205,379 nodes", 3,
           root(body(grid((59, 59, 59), (.2, .2, .2)), tets(1e5, .4, "svd"), cells=t), .01), ("SparseLDLSolver", "warped"))
    yield ("incompressible_plate", "statics: plate, Poisson's ratio 0.4995, 4,950 nodes", 1,
           root(body(grid((33, 25, 6), (.2, .15, .03)), hexas(5e4, .4995, "svd", 'dilatation="mean"'), STATIC), 1))
    yield "contact", "block under a tool with friction, Newton's method, 4,725 nodes", 20, contact()
    yield "frames", "beam between rigid frames on springs, `polar`, 2,403 nodes", 40, between_frames()
    layers = [5e6 if (i // 12) % 2 else 5e3 for k in range(8) for j in range(8) for i in range(72)]
    yield ("layers", "tower of layers 1:1,000, Newton's method, 5,913 nodes", 12,
           root(body(grid((73, 9, 9), (.36, .04, .04)), hexas(numbers(layers), .4, "svd"), newton(1e-5)), .01, "-9.81 0 0"))
    yield ("gel", "hexahedra, `small`, 4,845 nodes, 120 steps", 120,
           root(body(grid((19, 17, 15), (.09, .08, .07)), hexas(3e4, .4, "small")), .01))
    yield ("cone", "statics: cone, Mooney-Rivlin, 8,281 nodes", 1,
           root(body(bent((49, 13, 13), cone), law("MooneyRivlin", 'youngModulus="1e5" poissonRatio="0.45" c2="2000"'), STATIC,
                     cells=t), 1))


def late():
    t = "tetrahedra"

    def tube(u, v, w):
        turn, r = math.pi * (1 - v), .03 + .008 * w
        return .2 * u, r * math.cos(turn), r * math.sin(turn)

    def wedge(u, v, w):
        return .18 * u, .05 * v * (1 - .7 * u), .07 * w

    yield ("tube", "half tube of hexahedra, `svd`, 3,300 nodes", 20,
           root(body(bent((33, 25, 4), tube), hexas(1.5e5, .45, "svd")), .015))
    yield ("pillar", "statics: pillar, Arruda-Boyce, 3,375 nodes", 1,
           root(body(grid((27, 11, 11), (.2, .07, .07)), law("ArrudaBoyce", 'youngModulus="3e4" poissonRatio="0.44"'), STATIC,
                     cells=t), 1))
    yield ("net", "block of springs, 2,904 nodes", 25,
           root(body(grid((24, 11, 11), (.23, .1, .1)),
                     '<MeshSpringForceField name="net" hexasStiffness="60" hexasDamping="0.1"/>'), .01))
    yield ("sail", "membrane, 2,500 nodes", 25,
           root(membrane("50 50", "0.4 0.4", 0.1, "2e5", 0.3, 0.001), .01))
    yield ("pressed", "statics: slab under pressure, `large`, 4,800 nodes", 1,
           root(body(grid((30, 20, 8), (.3, .2, .06)), tets(9e4, .4, "large"), STATIC, cells=t, wall="-1 -1 -1 1 1 0.0001",
                     more='<SurfacePressureForceField name="load" topology="@tetrahedra" min="-1 -1 0.0599" max="0.15 1 1" '
                     'pressure="2000"/>'), 1))
    yield ("pulled", "bar that is pulled, neo-Hookean, Newton's method, 2,205 nodes", 12,
           root(body(grid((45, 7, 7), (.3, .04, .04)), law("NeoHookean", 'youngModulus="5e4" poissonRatio="0.4"'), newton(1e-6),
                     cells=t, more=moved_end(0.2999, "0 0.24", "0 0 0  0.06 0.02 0")), .02))
    yield ("swing", "wedge, `svd`, `NewmarkImplicitSolver`, 3,510 nodes", 20,
           root(body(bent((27, 10, 13), wedge), tets(6e4, .35, "svd"),
                     '<NewmarkImplicitSolver name="solver" gamma="0.5" beta="0.25"/>', cells=t), .01))
    yield ("organ_plain", "organ, `svd`, 1,400 nodes", 60,
           root(body(loaded("organ_5000"), tets(6e3, .47, "svd"), density=1060, wall="-1 0.03 -1 1 1 1"), .01))
    yield ("linear_bdf", "hexahedra, `small`, `BDFOdeSolver`, 3,200 nodes", 60,
           root(body(grid((32, 10, 10), (.25, .08, .08)), hexas(8e4, .35, "small"),
                     '<BDFOdeSolver name="solver" order="2"/>'), .01))
    yield ("veronda", "Veronda-Westmann, Newton's method, 2,736 nodes", 8,
           root(body(grid((19, 12, 12), (.14, .08, .08)), law("VerondaWestman", 'ParameterSet="4000 2 60000"'), newton(1e-5),
                     cells=t), .02))
    labels = loaded("leg") + '<ValuesFromLabels name="stiffness" labels="@loader.tetrahedraGroups" table="1 1e4 2 1e6 3 1e6"/>'
    yield ("leg_falls", "leg with bones 1:100, `svd`, implicit steps", 20,
           root(body(labels, tets("@stiffness.values", .45, "svd"), density=1060,
                     wall="-0.030 -0.015 0.320 0.016 0.032 0.346  -0.026 -0.016 0.018 0.030 0.026 0.040"), .02))
    inner = quadratics("16 6 6", "0.25 0.06 0.06", STATIC, "3e5", 0.4)
    yield "quadratic_static", "statics: quadratic tetrahedra, `svd`, 3,751 nodes", 1, root(inner, 1)


def held_out():
    t = "tetrahedra"

    def ring(u, v, w):
        turn, r = 1.5 * math.pi * (1 - u), .05 + .012 * v
        return r * math.cos(turn), r * math.sin(turn), .014 * w

    def dome(u, v, w):
        r, a, b = .06 + .02 * w, .7 * (2 * u - 1), .7 * (2 * v - 1)
        return -r * math.sin(a), r * math.cos(a) * math.cos(b), r * math.sin(b)

    yield ("strap", "strap of tetrahedra, `large`, held at both ends, 3,075 nodes", 25,
           root(body(grid((41, 25, 3), (.3, .18, .008)), tets(4e5, .4, "large"), cells=t,
                     wall="-0.0001 -10 -10 0.0001 10 10 0.2999 -10 -10 0.3001 10 10"), .015))
    yield ("ring", "three quarters of a ring, hexahedra, `large`, Newton's method, 4,941 nodes", 10,
           root(body(bent((61, 9, 9), ring), hexas(1.2e5, .43, "large"), newton(1e-5), wall="-1 -0.0001 -1 1 0.0001 1"), .02))
    yield ("dome", "dome under pressure, Mooney-Rivlin, Newton's method, 3,969 nodes", 8,
           root(body(bent((21, 21, 9), dome), law("MooneyRivlin", 'youngModulus="6e4" poissonRatio="0.45" c2="1500"'),
                     newton(1e-5), cells=t, wall="-1 -1 -1 1 0.048 1",
                     more='<SurfacePressureForceField name="load" topology="@tetrahedra" min="-1 -1 -1" max="1 1 1" '
                     'pressure="300"/>'), .02))
    spots = [(.02 + .03 * i, .03, .0201) for i in range(5)]
    yield ("hung", "block with masses embedded in it, `polar`, 5,049 nodes", 30,
           root(body(grid((51, 11, 9), (.2, .05, .04)), hexas(9e4, .4, "polar"),
                     more='<Node name="spots"><MechanicalObject position="' + numbers(c for p in spots for c in p)
                     + '"/><UniformMass totalMass="0.05"/><BarycentricMapping input="@../dofs"/></Node>'), .01))
    pair = "".join(body(grid((17, 11, 11), (.1, .06, .06), (0, .1 * i, 0)), tets(young, .4, "svd"), "", t, solver="")
                   .replace('name="body"', f'name="body{i}"') for i, young in enumerate((8e3, 8e5)))
    yield "pair", "two blocks of one solver, 1:100, `svd`, 4,114 nodes", 25, root(EULER + "@SOLVER@" + pair, .01)
    yield ("bdf", "hexahedra, `svd`, `BDFOdeSolver`, 4,800 nodes", 25,
           root(body(grid((30, 16, 10), (.2, .1, .06)), hexas(6e4, .42, "svd"), '<BDFOdeSolver name="solver" order="2"/>'), .01))
    yield ("springs", "statics: block of springs, 6,137 nodes", 1,
           root(body(grid((19, 19, 17), (.1, .1, .09)),
                     '<MeshSpringForceField name="net" hexasStiffness="200" hexasDamping="0"/>', STATIC), 1))
    yield ("large_block", "block of tetrahedra, `svd`, 19,773 nodes, 8 steps", 8,
           root(body(grid((39, 39, 13), (.2, .2, .06)), tets(2e5, .4, "svd"), cells=t), .02))
    inner = quadratics("20 5 5", "0.3 0.04 0.04", EULER, "4e5", 0.38)
    yield "quadratic_bar", "bar of quadratic tetrahedra, `svd`, 3,159 nodes", 15, root(inner, .01)
    yield ("tiny", "block of hexahedra, `polar`, 640 nodes, 200 steps", 200,
           root(body(grid((10, 8, 8), (.08, .06, .06)), hexas(5e4, .4, "polar"), '<NewmarkImplicitSolver name="solver"/>'), .01))


def unseen():
    t = "tetrahedra"

    def spiral(u, v, w):
        turn, r = 4 * (1 - u), .08 - .05 * u + .01 * v
        return r * math.cos(turn), r * math.sin(turn), .012 * w

    yield ("lattice", "mat of springs, `NewmarkImplicitSolver`, 2,880 nodes", 40,
           root(body(grid((40, 12, 6), (.39, .11, .05)),
                     '<MeshSpringForceField name="net" hexasStiffness="150" hexasDamping="0.05"/>',
                     '<NewmarkImplicitSolver name="solver"/>'), .008))
    yield ("flag", "membrane held at a side, 1,800 nodes", 40,
           root(membrane("60 30", "0.6 0.3", 0.05, "5e5", 0.25, 0.0008), .02))
    inner = quadratics("11 9 5", "0.12 0.1 0.03", EULER, "5e4", 0.42)
    yield "quadratic_plate", "plate of quadratic tetrahedra, `svd`", 20, root(inner, .015)
    yield ("jelly", "hexahedra, Poisson's ratio 0.499, `polar`, 3,536 nodes", 25,
           root(body(grid((26, 17, 8), (.12, .08, .035)), hexas(1e4, .499, "polar", 'dilatation="mean"')), .02))
    yield ("bdf_tets", "tetrahedra, `svd`, `BDFOdeSolver`, 3,159 nodes", 30,
           root(body(grid((39, 9, 9), (.2, .045, .045)), tets(1.5e5, .4, "svd"), '<BDFOdeSolver name="solver" order="2"/>',
                     cells=t), .01))
    yield ("pole", "pole of hexahedra, `small`, 150 steps, 2,989 nodes", 150,
           root(body(grid((61, 7, 7), (.36, .036, .036)), hexas(2e6, .3, "small")), .01))
    mixed = "".join(body(grid(n, size, (0, .1 * i, 0)), field, "", kind, solver="").replace('name="body"', f'name="body{i}"')
                    for i, (n, size, field, kind) in enumerate((
                        ((14, 10, 10), (.09, .06, .06), hexas(4e4, .4, "polar"), "hexahedra"),
                        ((31, 6, 6), (.2, .03, .03), tets(3e5, .35, "svd"), t),
                        ((9, 9, 9), (.05, .05, .05), tets(2e3, .45, "svd"), t))))
    yield "three", "three bodies of one solver, hexahedra and tetrahedra, 3,245 nodes", 20, root(EULER + "@SOLVER@" + mixed, .01)
    yield ("coil", "spiral of hexahedra, `svd`, Newton's method, 4,199 nodes", 8,
           root(body(bent((84, 10, 5), spiral), hexas(8e4, .4, "svd"), newton(1e-5), wall="-1 -0.0001 -1 1 0.0001 1"), .015))
    yield ("twisted", "bar that is drawn aside, Mooney-Rivlin, Newton's method, 2,835 nodes", 12,
           root(body(grid((35, 9, 9), (.24, .05, .05)), law("MooneyRivlin", 'youngModulus="4e4" poissonRatio="0.43" c2="1000"'),
                     newton(1e-5), cells=t, more=moved_end(0.2399, "0 0.24", "0 0 0  0.02 0.05 0.01")), .02))
    yield ("loaded", "statics in six steps: block whose end is moved, `svd`, 4,096 nodes", 6,
           root(body(grid((16, 16, 16), (.1, .1, .1)), tets(5e4, .4, "svd"), STATIC, cells=t,
                     more=moved_end(0.0999, "0 6", "0 0 0  0.03 0.02 0")), 1))


def sponge():
    law = '<HexahedronHyperelasticityFEMForceField name="fem" materialName="NeoHookean" youngModulus="2e5" poissonRatio="0.15"/>'
    wet = ('<HexahedronPorousForceField name="fluid" fluidFraction="0.75" bulkModulus="5e4" limitModulus="1e7" permeability="4e-15" '
           'coupling="implicit" drainedIndices="@top.indices"/><BoxROI name="top" box="-1 -1 0.00299 1 1 1" '
           'position="@dofs.rest_position"/><ConstantForceField indices="@top.indices" totalForce="0 0 -0.8"/>')
    static = '<StaticSolver name="solver" newton_iterations="40" relative_residual_tolerance_threshold="1e-6" @FORCING_S@/>'
    return body(grid((15, 13, 8), (.008, .007, .003)), law, static, wall="-1 -1 -1 1 1 1e-6", more=wet)


def kinds():
    t = "tetrahedra"
    yield ("needle", "slender: hexahedra, `svd`, Newton's method, 3,216 nodes", 10,
           root(body(grid((201, 4, 4), (.5, .006, .006)), hexas(5e7, .35, "svd"), newton(1e-6)), .01))
    yield ("thick", "thick: tetrahedra, `large`, 5,814 nodes", 20,
           root(body(grid((19, 18, 17), (.12, .11, .1)), tets(6e4, .42, "large"), cells=t), .015))
    yield ("layers", "a layer 1:500 in tetrahedra, `svd`, 4,050 nodes", 15,
           root(body(grid((30, 15, 9), (.2, .1, .06)), tets(1.5e4, .45, "svd"), cells=t,
                     more=inside("-1 -1 0.029 1 1 0.046", t, 7.5e6, .3, "svd", t)), .01))
    yield "sheet", "shell: membrane with springs of bending, 1,326 nodes", 40, root(sheet(), .01, "0 0 -9.81")
    yield ("net", "springs in hexahedra, 2,583 nodes, implicit steps", 40,
           root(body(grid((41, 9, 7), (.4, .08, .06)),
                     '<MeshSpringForceField name="net" hexasStiffness="8000" hexasDamping="1"/>'), .01))
    yield ("beams", "chain of 600 beams, implicit steps", 40,
           root(f'<Node name="body">{EULER}@SOLVER@<RegularGridTopology name="grid" n="601 1 1" min="0 0 0" max="3 0 0"/>'
                '<MechanicalObject name="dofs" template="Rigid3"/><UniformMass vertexMass="0.002" inertia="1e-7 1e-7 1e-7"/>'
                '<FixedProjectiveConstraint indices="0 600"/>'
                '<BeamFEMForceField name="fem" radius="0.004" youngModulus="1e7" poissonRatio="0.4"/></Node>', .01))
    inner = quadratics("9 8 8", "0.1 0.09 0.08", newton(1e-5), "4e4", 0.4)
    yield "quadratic_block", "block of quadratic tetrahedra, `svd`, Newton's method, 3,825 nodes", 10, root(inner, .02)
    yield "sponge", "porous: statics, pressed for 40 s each, 1,560 nodes", 8, root(sponge(), 40, "0 0 0")
    yield ("rubber", "statics: hexahedra, Poisson's ratio 0.4995, neo-Hookean, 2,304 nodes", 1,
           root(body(grid((16, 12, 12), (.08, .06, .06)), '<HexahedronHyperelasticityFEMForceField name="fem" '
                     'materialName="NeoHookean" youngModulus="4e4" poissonRatio="0.4995" dilatation="mean"/>', STATIC), 1))
    yield ("landing", "contact: block that falls on a plane, `svd`, Newton's method, 2,873 nodes", 25,
           root(f'{newton(1e-4, 40)}@SOLVER@'
                + body(grid((17, 13, 13), (.08, .06, .06), (-.04, -.03, .004)), tets(3e4, .44, "svd"), "", t, solver="",
                       wall="-9 -9 -9 -8 -8 -8").replace(held("-9 -9 -9 -8 -8 -8"), "")
                + '<BarrierContact name="contact" mstate="@body/dofs" topology="@body/tetrahedra" contactDistance="0.003" '
                'planes="0 0 1 0" friction="0.3" slipVelocity="2e-3" selfContact="false"/>', .005, "0 0 -9.81"))


def scenes():
    for name, source in (("standing", standing), ("fresh", fresh), ("late", late), ("held", held_out), ("unseen", unseen),
                         ("kinds", kinds), ("mixed", mixed), ("further", further), ("users", users), ("blind", blind)):
        for found in source():
            yield Scene(found[0], name, *found[1:])
