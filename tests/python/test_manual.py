# SPDX-License-Identifier: LGPL-2.1-or-later
"""The example of every component's manual page: as a tree, as text again and as a copy it has the bits of its file, and each of
its attributes can be read."""
import re

import numpy
import stroma

EXAMPLE = re.compile(r"Example:\n(<(?:.*\n)*?</Node>)")
GIVEN = (bool, int, float, str, list, numpy.ndarray)


def test_every_example(folder):
    run, refused = [], []
    for type in sorted(stroma.types()):
        example = EXAMPLE.search(stroma.type_info(type).manual)
        if not example:
            assert type in ("PythonForceField", "PythonConstraint"), f"{type} has no example"
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
                  stroma.load(stroma.from_xml_text(stroma.to_xml(tree), "example.xml"), observers=False)]
        for simulation in scenes:
            simulation.run(2, check=False)
        scenes.append(read.copy())
        assert len({simulation.hash for simulation in scenes}) == 1, type
        for component in read.components():
            for attribute in component.attributes:
                assert isinstance(component.get(attribute), GIVEN), f"{component.type}.{attribute}"
        run.append(type)
    assert len(run) > 140 and len(refused) < 12, refused
