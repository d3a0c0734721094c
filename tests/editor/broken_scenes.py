# SPDX-License-Identifier: LGPL-2.1-or-later
"""A good scene and mistakes to plant in it, one at a time: what a schema and `stroma check` must both refuse."""

GOOD = """\
<?xml version="1.0" encoding="UTF-8"?>
<!-- A beam of soft tissue under its weight. -->
<Node name="root" gravity="0 -9.81 0" dt="0.01">
  <RequiredPlugin name="Sofa.Component.ODESolver"/>
  <RegularGridTopology name="grid" n="5 3 3" min="0 0 0" max="0.2 0.05 0.05"/>
  <Node name="body" activated="true">
    <EulerImplicitSolver name="solver" rayleighStiffness="0.02" rayleighMass="0.5"/>
    <PCGLinearSolver name="linear" iterations="25" tolerance="1e-5" preconditioner="jacobi"/>
    <TetrahedronSetTopologyContainer name="tets"/>
    <Hexa2TetraTopologicalMapping input="@../grid" output="@tets"/>
    <MechanicalObject name="dofs" position="@../grid.position" showObject="true"/>
    <UniformMass name="mass" totalMass="0.08" template="Vec3"/>
    <TetrahedronFEMForceField name="fem" method="polar" youngModulus="10000" poissonRatio="0.3"/>
    <BoxROI name="end" box="-0.01 -1 -1  0.01 1 1"/>
    <FixedConstraint indices="@end.indices"/>
    <Object type="ConstantForceField" indices="1-3" totalForce="0 0 0"/>
    <LinearMovementProjectiveConstraint indices="4" keyTimes="0 1" movements="0 0 0  0 0 0"/>
    <Monitor name="watch" indices="0, 1 2"/>
  </Node>
</Node>
"""

# What is wrong; the text in the scene; what stands there instead.
MISTAKES = [
    ("an attribute that the component does not have", 'totalMass="0.08"', 'totalMas="0.08"'),
    ("an attribute in the wrong case", 'youngModulus="10000"', 'YoungModulus="10000"'),
    ("a misspelt component", "<UniformMass ", "<UniformMas "),
    ("a component that is an element in the wrong case", "<BoxROI ", "<boxROI "),
    ("an old name with a mistake", "<FixedConstraint ", "<FixedConstrain "),
    ("a word that the choice does not have", 'method="polar"', 'method="pollar"'),
    ("a word in the wrong case", 'method="polar"', 'method="Polar"'),
    ("a word that a link does not have", 'preconditioner="jacobi"', 'preconditioner="jacoby"'),
    ("text where a number belongs", 'totalMass="0.08"', 'totalMass="heavy"'),
    ("a comma for the decimal point", 'tolerance="1e-5"', 'tolerance="0,00001"'),
    ("a fraction where a whole number belongs", 'iterations="25"', 'iterations="25.5"'),
    ("nothing where a number belongs", 'rayleighMass="0.5"', 'rayleighMass=""'),
    ("two numbers of three, on a Node", 'gravity="0 -9.81 0"', 'gravity="0 -9.81"'),
    ("four numbers of three", 'max="0.2 0.05 0.05"', 'max="0.2 0.05 0.05 1"'),
    ("two whole numbers of three", 'n="5 3 3"', 'n="5 3"'),
    ("a word among numbers", 'keyTimes="0 1"', 'keyTimes="0 one"'),
    ("a word among whole numbers", 'indices="0, 1 2"', 'indices="0, 1 two"'),
    ("a range that has no end", 'indices="0, 1 2"', 'indices="0, 1-"'),
    ("a negative distance between marks", 'indices="4"', 'indices="3--7"'),
    ("a unit in the wrong case", 'youngModulus="10000"', 'youngModulus="10 kpa"'),
    ("a unit that there is not", 'totalMass="0.08"', 'totalMass="80 grams"'),
    ("a number above its range", 'poissonRatio="0.3"', 'poissonRatio="0.6"'),
    ("a number at the open end of its range", 'poissonRatio="0.3"', 'poissonRatio="0.5"'),
    ("a number below its range", 'rayleighStiffness="0.02"', 'rayleighStiffness="-1"'),
    ("no number, as XML Schema writes it", 'totalMass="0.08"', 'totalMass="NaN"'),
    ("no finite number", 'keyTimes="0 1"', 'keyTimes="0 INF"'),
    ("no finite number below", 'gravity="0 -9.81 0"', 'gravity="-INF"'),
    ("a unit with a power that is none", 'youngModulus="10000"', 'youngModulus="10 N**m"'),
    ("two names of units as one", 'youngModulus="10000"', 'youngModulus="10 Nm"'),
    ("a Node inside a component", "<BoxROI name=\"end\" box=\"-0.01 -1 -1  0.01 1 1\"/>",
     "<BoxROI name=\"end\" box=\"-0.01 -1 -1  0.01 1 1\"><Node/></BoxROI>"),
    ("a component inside a component", 'template="Vec3"/>', 'template="Vec3"><BoxROI/></UniformMass>'),
    ("a required attribute that is not there", '<Monitor name="watch" indices="0, 1 2"/>', '<WriteState name="watch"/>'),
    ("a list that must be given and is not", '<Monitor name="watch" indices="0, 1 2"/>', '<TorsionForceField name="watch"/>'),
    ("an attribute that a Node does not have", 'dt="0.01"', 'timeStep="0.01"'),
    ("a time step of zero", 'dt="0.01"', 'dt="0"'),
    ("a word for a time step", 'dt="0.01"', 'dt="fast"'),
    ("a word that is neither true nor false", 'activated="true"', 'activated="yes"'),
    ("a computed value that is written", 'box="-0.01 -1 -1  0.01 1 1"', 'box="-0.01 -1 -1  0.01 1 1" indices="1 2"'),
    ("a Node in the wrong case", '<Node name="body" activated="true">', '<node name="body" activated="true">', "tags"),
    ("an include without a file", '<BoxROI name="end" box="-0.01 -1 -1  0.01 1 1"/>', '<include name="end"/>'),
    ("an Object without a type", 'Object type="ConstantForceField"', "Object"),
    ("an Object of a type that is none", 'Object type="ConstantForceField"', 'Object type="ConstantForceFeld"'),
    ("a template that there is not", 'template="Vec3"', 'template="Rigid4"'),
    ("an outermost element that is none", '<Node name="root"', '<Scene name="root"', "tags"),
]


def broken(mistake):
    """The scene with one mistake, and the line where it stands."""
    what, right, wrong = mistake[:3]
    assert GOOD.count(right) == 1, f"{what}: {right!r} stands {GOOD.count(right)} times in the scene"
    line = GOOD[:GOOD.index(right)].count("\n") + 1
    text = GOOD.replace(right, wrong)
    if mistake[3:] == ("tags",):  # the end tag has the name too
        old, new = right.split()[0][1:], wrong.split()[0][1:]
        end = text.rindex("</" + old + ">") if old == "Node" and new == "Scene" else text.index("</" + old + ">")
        text = text[:end] + "</" + new + ">" + text[end + len(old) + 3:]
    return text, line
