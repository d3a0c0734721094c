# SPDX-License-Identifier: LGPL-2.1-or-later
"""The example of every component's manual page: as a tree, as text again, as a program and as a copy it has the bits of its file,
and each of its attributes can be read."""
import re

import numpy
import stroma

EXAMPLE = re.compile(r"Example:\n(<(?:.*\n)*?</Node>)")
GIVEN = (bool, int, float, str, list, numpy.ndarray)


def built_by(program):
    names = {}
    exec(compile(program, "example.py", "exec"), names)
    return names["root"]


def test_a_program_reads_well():
    scene = """<Node name="root" gravity="0 -9.81 0" dt="20 ms"><MechanicalObject name="dofs" position="0 0 0  1 0 .5"/>
        <UniformMass totalMass="1e-2"/><Node name="import"><BoxROI name="a &quot;b" box="0 0 0 1 1 1" strict="true"/>
        <FixedProjectiveConstraint indices="0-3 7" mstate="@../dofs"/></Node><Node name="import"/></Node>"""
    assert stroma.to_python(stroma.from_xml_text(scene)) == '''import stroma

root = stroma.Node("root", gravity=(0, -9.81, 0), dt="20 ms")
root.add("MechanicalObject", name="dofs", position=[(0, 0, 0), (1, 0, .5)])
root.add("UniformMass", totalMass=1e-2)

node_import = root.add_child("import")
node_import.add("BoxROI", name="a \\"b", box=(0, 0, 0, 1, 1, 1), strict=True)
node_import.add("FixedProjectiveConstraint", indices="0-3 7", mstate="@../dofs")

node_import_2 = root.add_child("import")
'''


def test_names_that_are_made_take_no_place_of_others():
    tree = stroma.from_xml_text("""<Node name="root"><Node name="a"><Node name="a"><Node name="a_2"/><Node name="z">
        <MechanicalObject position="-0 1 2  1e400 0 0"/></Node></Node></Node></Node>""")
    assert stroma.to_xml(built_by(stroma.to_python(tree))) == stroma.to_xml(tree)


def test_every_example(folder):
    run, refused = [], []
    for type in sorted(stroma.types()):
        example = EXAMPLE.search(stroma.type_info(type).manual)
        if not example:
            assert type in ("PythonForceField", "PythonConstraint", "PythonMapping"), f"{type} has no example"
            continue
        (folder / "example.xml").write_text(example.group(1))
        try:
            read = stroma.load("example.xml", observers=False)
        except stroma.SceneError as error:  # it reads a file that is not here
            assert "is not found" in str(error), f"{type}: {error}"
            refused.append(type)
            continue
        tree = stroma.from_xml("example.xml", strict=True)
        scenes = [read, stroma.load(tree, observers=False),
                  stroma.load(stroma.from_xml_text(stroma.to_xml(tree), "example.xml"), observers=False),
                  stroma.load(built_by(stroma.to_python(tree)), observers=False)]
        for simulation in scenes:
            simulation.run(2, check=False)
        scenes.append(read.copy())
        assert len({simulation.hash for simulation in scenes}) == 1, type
        for component in read.components():
            for attribute in component.attributes:
                value = component.get(attribute)
                assert isinstance(value, GIVEN), f"{component.type}.{attribute}"
                assert numpy.array_equal(scenes[3][component.path].get(attribute), value), f"{component.type}.{attribute} of the program"
        run.append(type)
    assert len(run) > 140 and len(refused) < len(run) / 10, refused
