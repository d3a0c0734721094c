# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the scenes of solver_choice.py are written with: a scene, its solver, bodies, laws, supports. SI units."""
import os
import re

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
MESHES = os.path.join(ROOT, "scenes", "meshes")


class Scene:
    def __init__(self, name, set_name, about, steps, template, without=()):
        self.name, self.set, self.about, self.steps, self.template, self.without = name, set_name, about, steps, template, without

    def text(self, solver, forcing=None):
        word = {"S": f'forcing_term="{forcing}"', "N": f'newtonForcing="{forcing}"'}
        return re.sub(r"@FORCING_(.)@", lambda m: word[m.group(1)] if forcing else "", self.template.replace("@SOLVER@", solver))

    def forcing(self, value):
        return value if "@FORCING_" in self.template else None


def root(inner, dt, gravity="0 -9.81 0"):
    return f'<Node name="root" gravity="{gravity}" dt="{dt}">\n{inner}\n</Node>\n'


EULER = '<EulerImplicitSolver name="solver"/>'
STATIC = '<StaticSolver name="solver" @FORCING_S@/>'


def newton(tolerance=1e-6, iterations=20):
    return f'<EulerImplicitSolver name="solver" newtonIterations="{iterations}" newtonTolerance="{tolerance}" @FORCING_N@/>'


def tets(young, poisson, method):
    return f'<TetrahedronFEMForceField name="fem" youngModulus="{young}" poissonRatio="{poisson}" method="{method}"/>'


def hexas(young, poisson, method, more=""):
    return f'<HexahedronFEMForceField name="fem" youngModulus="{young}" poissonRatio="{poisson}" method="{method}" {more}/>'


def law(name, parameters):
    return f'<TetrahedronHyperelasticityFEMForceField name="fem" materialName="{name}" {parameters}/>'


def numbers(values):
    return " ".join(f"{v:.9g}" for v in values)


def held(box):
    return (f'<BoxROI name="wall" box="{box}" position="@dofs.rest_position"/>'
            '<FixedProjectiveConstraint name="held" indices="@wall.indices"/>')


def bent(n, place):
    """A grid of hexahedra whose nodes `place` puts from 0..1 on each axis."""
    points = [c for k in range(n[2]) for j in range(n[1]) for i in range(n[0])
              for c in place(i / (n[0] - 1), j / (n[1] - 1), k / (n[2] - 1))]
    at = lambda i, j, k: i + n[0] * (j + n[1] * k)  # noqa: E731
    corners = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
    places = [(i, j, k) for k in range(n[2] - 1) for j in range(n[1] - 1) for i in range(n[0] - 1)]
    cells = [at(i + a, j + b, k + c) for i, j, k in places for a, b, c in corners]
    return f'<MeshTopology name="grid" position="{numbers(points)}" hexahedra="{" ".join(map(str, cells))}"/>'


def grid(n, size, start=(0, 0, 0)):
    return f'<RegularGridTopology name="grid" n="{numbers(n)}" min="{numbers(start)}" max="{numbers(map(sum, zip(start, size)))}"/>'


def body(mesh, field, integrator=EULER, cells="hexahedra", density=1000, wall="-0.0001 -10 -10 0.0001 10 10", more="",
         solver="@SOLVER@"):
    """A body in a node of its own; tetrahedra are five in each hexahedron. `more` may select nodes of @dofs."""
    text = f'<Node name="body">{integrator}{solver}\n{mesh}\n<MechanicalObject name="dofs"/>{held(wall)}\n'
    if cells == "tetrahedra":
        text += ('<TetrahedronSetTopologyContainer name="tetrahedra"/>'
                 '<Hexa2TetraTopologicalMapping name="cut" input="@grid" output="@tetrahedra" cutting="five"/>\n'
                 f'<DiagonalMass massDensity="{density}" topology="@tetrahedra"/>\n'
                 + field.replace("/>", ' topology="@tetrahedra"/>'))
    else:
        text += f'<DiagonalMass massDensity="{density}"/>\n{field}'
    return f"{text}\n{more}</Node>"


def inside(box, what, young, poisson, method, kind):
    """Cells in a box that are stiffer."""
    name = {"tetrahedra": "Tetrahedron", "hexahedra": "Hexahedron"}[kind]
    return (f'<BoxROI name="core" box="{box}" position="@dofs.rest_position" {kind}="@{what}.{kind}"/><Node name="bone">'
            f'<{name}SetTopologyContainer name="sub" position="@../grid.position" {kind}="@../core.{kind}InROI"/>'
            f'<{name}FEMForceField name="stiff" youngModulus="{young}" poissonRatio="{poisson}" method="{method}" '
            'mstate="@../dofs" topology="@sub"/></Node>')


def cable(points, pull, how):
    places = "  ".join(numbers(p) for p in points)
    return (f'<Node name="cable"><MechanicalObject position="{places}"/><CableConstraint name="pull" '
            f'indices="{" ".join(str(i) for i in range(len(points)))}" pullPoint="{pull}" {how}/>'
            '<BarycentricMapping input="@../dofs"/></Node>')


def quadratics(n, size, integrator, young, poisson, method="svd"):
    """A block of quadratic tetrahedra, held at x = 0."""
    return (f'<RegularGridTopology name="grid" n="{n}" min="0 0 0" max="{size}"/><Node name="body">{integrator}@SOLVER@'
            '<Hexa2TetraTopologicalMapping name="tetrahedra" input="@../grid" swapping="true"/>'
            '<Linear2QuadraticTopologicalMapping name="mesh" input="@tetrahedra"/><MechanicalObject name="dofs" src="@mesh"/>'
            '<DiagonalMass massDensity="1000" topology="@mesh"/><QuadraticTetrahedronFEMForceField name="fem" topology="@mesh" '
            f'youngModulus="{young}" poissonRatio="{poisson}" method="{method}"/>{held("-0.0001 -1 -1 0.0001 1 1")}</Node>')


def membrane(n, size, mass, young, poisson, thickness):
    """A sheet of triangles, held at x = 0."""
    return (f'<Node name="body">{EULER}@SOLVER@<RegularGridTopology name="grid" n="{n} 1" min="0 0 0" max="{size} 0"/>'
            '<TriangleSetTopologyContainer name="sheet"/><Quad2TriangleTopologicalMapping name="cut" input="@grid" '
            f'output="@sheet"/><MechanicalObject name="dofs" position="@grid.position"/><UniformMass totalMass="{mass}"/>'
            f'<TriangularFEMForceField name="fem" topology="@sheet" youngModulus="{young}" poissonRatio="{poisson}" '
            f'thickness="{thickness}"/>' + held("-0.0001 -1 -1 0.0001 1 1") + "</Node>")


def loaded(name):
    """A mesh of tetrahedra."""
    return (f'<MeshGmshLoader name="loader" filename="{MESHES}/{name}.msh"/>'
            '<TetrahedronSetTopologyContainer name="grid" src="@loader"/>')


def moved_end(x, times, movements):
    """The nodes of a body's end, led."""
    return (f'<BoxROI name="end" box="{x} -1 -1 1 1 1" position="@dofs.rest_position"/><LinearMovementProjectiveConstraint '
            f'name="hand" indices="@end.indices" keyTimes="{times}" movements="{movements}"/>')


NOWHERE = "-9 -9 -9 -8 -8 -8"


def unheld(text):
    """A body without what holds it."""
    return text.replace(held(NOWHERE), "")


def sheet():
    """A shell: a membrane with springs of bending."""
    return (f'<Node name="body">{EULER}@SOLVER@<RegularGridTopology name="grid" n="51 26 1" min="0 0 0" max="0.4 0.2 0" '
            'computeTriangleList="true"/><TriangleSetTopologyContainer name="sheet" position="@grid.position" '
            'triangles="@grid.triangles"/><MechanicalObject name="dofs" position="@grid.position"/>'
            '<MeshMatrixMass topology="@sheet" massDensity="1.1" lumping="true"/>'
            '<TriangularFEMForceField name="fem" topology="@sheet" youngModulus="3e5" poissonRatio="0.3" thickness="0.001"/>'
            '<FastTriangularBendingSprings name="bending" topology="@sheet" bendingStiffness="5e-4"/>'
            + held("-0.0001 -1 -1 0.0001 1 1") + "</Node>")
