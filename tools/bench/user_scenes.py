#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Five scenes of solver_choice.py, the set `users`: what people build who simulate soft robots, muscles, catheters and brains. They were
written without a look at what is chosen for them, and only measured. SI units."""
import math

from scene_parts import EULER, NOWHERE, STATIC, bent, body, cable, grid, law, newton, root, tets, unheld

T = "tetrahedra"


def pad(name, x, path):
    """A rigid plate that a motor moves along x."""
    moves = "0 0 0  0 0 0   {0} 0 0  0 0 0   {0} 0 0  0 0 0   {0} 0 0.02  0 0 0".format(path)
    return (f'<Node name="{name}"><MechanicalObject name="frame" template="Rigid3" position="{x} 0 0.03 0 0 0 1"/>'
            '<UniformMass totalMass="0.05" inertia="1e-5 1e-5 1e-5"/><LinearMovementProjectiveConstraint indices="0" '
            f'keyTimes="0 0.1 0.15 0.5" outside="hold" movements="{moves}"/>'
            '<Node name="pad"><MeshTopology name="mesh" position="-0.004 -0.03 -0.03  0.004 -0.03 -0.03  -0.004 0.03 -0.03  '
            '0.004 0.03 -0.03  -0.004 -0.03 0.03  0.004 -0.03 0.03  -0.004 0.03 0.03  0.004 0.03 0.03" '
            'triangles="0 2 1  1 2 3  4 5 6  5 7 6  0 1 4  1 5 4  2 6 3  3 6 7  0 4 2  2 4 6  1 3 5  3 7 5"/>'
            '<MechanicalObject name="dofs"/><RigidMapping/></Node></Node>')


def ball(u, v, w):
    """A cube of nodes that is pulled to a ball."""
    p = [2 * c - 1 for c in (u, v, w)]
    far = max(map(abs, p)) / (math.sqrt(sum(c * c for c in p)) or 1)
    return [.022 * c * (.4 + .6 * far) + at for c, at in zip(p, (0, 0, .0245))]


def gripper():
    fruit = unheld(body(bent((13, 13, 13), ball), law("StableNeoHookean", 'youngModulus="2e4" poissonRatio="0.45"'), "", T, solver="",
                      wall=NOWHERE))
    touch = ('<BarrierContact name="grip" mstate="@body/dofs" topology="@body/tetrahedra" other="@left/pad/dofs @right/pad/dofs" '
             'contactDistance="0.002" friction="0.6" slipVelocity="1e-3" selfContact="false"/>'
             '<BarrierContact name="table" mstate="@body/dofs" topology="@body/tetrahedra" planes="0 0 1 0" contactDistance="0.002" '
             'friction="0.3" slipVelocity="1e-3" selfContact="false"/>')
    return newton(1e-4, 40) + "@SOLVER@" + fruit + pad("left", -.03, .006) + pad("right", .03, -.006) + touch


def muscle():
    def belly(u, v, w):
        wide = .012 + .02 * math.sin(math.pi * u)
        return .16 * u, wide * (v - .5), wide * (w - .5)
    fibres = ('<TetrahedronHyperelasticityFEMForceField name="fem" materialName="Costa" a="2000" k0="1e5" bff="8" bss="2" bnn="2" bsn="2" '
              'bfs="4" bfn="4" AnisotropyDirections="1 0 0  0 1 0"/>')
    load = ('<BoxROI name="far" box="0.1599 -1 -1 1 1 1" position="@dofs.rest_position"/>'
            '<ConstantForceField indices="@far.indices" totalForce="0.1 0 -0.2"/>')
    return body(bent((33, 10, 10), belly), fibres, newton(1e-5), T, 1060, more=load)


def catheter():
    def wall(u, v, w):
        r, turn = .005 + .002 * w, -2 * math.pi * v * 27 / 28
        return .16 * u, r * math.cos(turn) + .05 * max(0, u - .35) ** 2, r * math.sin(turn)
    vessel = body(bent((41, 28, 3), wall), law("NeoHookean", 'youngModulus="2e5" poissonRatio="0.45"'), "", T, 1060, solver="",
                  wall="-1 -1 -1 0.001 1 1")
    frames = "  ".join(f"{-.1 + .006 * k:.4f} 0 0 0 0 0 1" for k in range(26))
    points = "  ".join(f"{-.1 + .006 * k:.4f} 0 0" for k in range(26))
    edges = " ".join(f"{k} {k + 1}" for k in range(25))
    rod = (f'<Node name="rod"><MeshTopology name="line" edges="{edges}"/><MechanicalObject name="frames" template="Rigid3" '
           f'position="{frames}"/><UniformMass vertexMass="2e-4" inertia="1e-9 1e-9 1e-9"/><BeamFEMForceField youngModulus="2e8" '
           'poissonRatio="0.4" radius="0.0007"/><LinearMovementProjectiveConstraint indices="0" keyTimes="0 0.2" outside="hold" '
           'movements="0 0 0  0 0 0   0.08 0 0  0 0 0"/>'
           f'<Node name="axis"><MeshTopology name="mesh" position="{points}" edges="{edges}"/><MechanicalObject name="dofs"/>'
           f'<RigidMapping rigidIndexPerPoint="{" ".join(map(str, range(26)))}" globalToLocalCoords="true"/></Node></Node>')
    touch = ('<BarrierContact name="touch" mstate="@body/dofs" topology="@body/tetrahedra" other="@rod/axis/dofs" '
             'contactDistance="0.0015" friction="0.05" slipVelocity="2e-3" selfContact="false"/>')
    return newton(1e-4, 40) + "@SOLVER@" + vessel + rod + touch


def brain():
    def half(u, v, w):
        p = [2 * c - 1 for c in (u, v, w)]
        far = max(map(abs, p)) / (math.sqrt(sum(c * c for c in p)) or 1)
        return [s * c * (.45 + .55 * far) for s, c in zip((.08, .06, .055), p)]
    tissue = ('<HexahedronHyperelasticityFEMForceField name="fem" materialName="NeoHookean" youngModulus="3e3" poissonRatio="0.495" '
              'dilatation="mean"/>')
    skull = ('<BarrierContact name="skull" mstate="@dofs" topology="@grid" planes="0 0 1 -0.0565" contactDistance="0.003" '
             'friction="0" selfContact="false"/>')
    stem = '<BoxROI name="stem" box="-0.03 -1 -1 0.03 1 -0.045" position="@dofs.rest_position"/>'
    soft = ('<BoxROI name="dura" box="-1 -1 -1 1 -0.02 1" position="@dofs.rest_position"/>'
            '<RestShapeSpringsForceField name="bridging" points="@dura.indices" stiffness="0.05"/>')
    return body(bent((19, 17, 16), half), tissue, STATIC, density=1040, wall="-0.03 -1 -0.06 0.03 1 -0.047", more=soft + stem + skull)


def limb():
    n = (31, 8)
    points = [(.2 * i / 30, .02 + .02 * math.cos(2 * math.pi * j / 8), .02 + .02 * math.sin(2 * math.pi * j / 8))
              for j in range(n[1]) for i in range(n[0])]
    at = lambda i, j: i + n[0] * (j % n[1])  # noqa: E731
    sheet = " ".join(f"{at(i, j)} {at(i + 1, j)} {at(i + 1, j + 1)}  {at(i, j)} {at(i + 1, j + 1)} {at(i, j + 1)}"
                     for j in range(n[1]) for i in range(n[0] - 1))
    skin = ('<Node name="skin"><TriangleSetTopologyContainer name="sheet" position="'
            + "  ".join(f"{a:.5f} {b:.5f} {c:.5f}" for a, b, c in points) + f'" triangles="{sheet}"/>'
            '<MechanicalObject name="points" position="@sheet.position"/><TriangularFEMForceField topology="@sheet" youngModulus="5e5" '
            'poissonRatio="0.4" thickness="0.001"/><BarycentricMapping input="@../dofs"/></Node>')
    pulled = cable([(.02 + .02 * i, .036, .02) for i in range(9)], "-0.02 0.036 0.02", 'valueType="displacement" value="0.008"')
    return body(grid((41, 9, 9), (.2, .04, .04)), tets(1.5e5, .45, "svd"), EULER, T, 1050, more=skin + pulled)


def users():
    yield ("gripper", "soft ball between two plates with friction that lift it, stable neo-Hookean, 2,197 nodes", 30,
           root(gripper(), .01, "0 0 -9.81"))
    yield "muscle", "muscle with fibres that is stretched, Costa's law, Newton's method, 3,300 nodes", 15, root(muscle(), .02)
    yield "guided", "catheter of beams that is pushed into a soft vessel, 3,444 nodes", 20, root(catheter(), .01, "0 0 0")
    yield "brain", "statics: brain that sinks against a plane, Poisson's ratio 0.495, 5,168 nodes", 1, root(brain(), 1, "0 0 2")
    yield "limb_with_skin", "limb of tetrahedra with a skin mapped on it, under a cable, 3,321 nodes", 12, root(limb(), .05)
