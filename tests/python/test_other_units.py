# SPDX-License-Identifier: LGPL-2.1-or-later
"""The example of every component's manual page in other units of length, mass and time. The units are powers of two of those of the
page, so that a run in which no number is compared with one of another dimension has the same numbers to the bit."""
import math
import re

import numpy
import pytest
import stroma

EXAMPLE = re.compile(r"Example:\n(<(?:.*\n)*?</Node>)")
LENGTH, NUMBER, SPEED, TURN, FORCE, TORQUE = (1, 0, 0), (0, 0, 0), (1, 0, -1), (0, 0, -1), (1, 1, -2), (2, 1, -2)
BASE = {"m": LENGTH, "kg": (0, 1, 0), "s": (0, 0, 1), "N": FORCE, "Pa": (-1, 1, -2), "J": TORQUE,
        **dict.fromkeys(["-", "1", "degree", "deg", "rad", "GB"], NUMBER)}
PLACE, PUSH = [LENGTH] * 3 + [NUMBER] * 4, [FORCE] * 3 + [TORQUE] * 3
OF_FRAMES = {"position": PLACE, "rest_position": PLACE, "velocity": [SPEED] * 3 + [TURN] * 3, "forces": PUSH, "totalForce": PUSH,
             "movements": [LENGTH] * 3 + [NUMBER] * 3, "velocities": [SPEED] * 3 + [TURN] * 3}
MIXED = {"planes": [NUMBER] * 3 + [LENGTH], "spring": [NUMBER, NUMBER, (0, 1, -2), (0, 1, -1), LENGTH],
         "oscillators": [NUMBER] + [LENGTH] * 6 + [TURN, NUMBER]}
# examples with numbers whose dimension no attribute tells: text of formulas, lists of values, nodes that are angles, square roots,
# a size that is a count below zero
UNTOLD = {"FormulaForceField", "Expect", "FrameSpringForceField", "GearSpringForceField", "JointSpringForceField", "SphereCollisionModel",
          "MathOp", "MergeVectors", "ValuesFromLabels", "ROIValueMapper", "Indices2ValuesMapper", "IndexValueMapper", "DifferenceEngine",
          "StopperLagrangianConstraint", "BeamHookeLawForceField", "DiscreteCosseratMapping", "MeshTetraStuffing"}
# examples that rely on a default with a unit
BY_DEFAULT = {"GridMeshCreator", "StringMeshCreator", "PolynomialRestShapeSpringsForceField"}
# the exact number depends on the units of lengths and angles: a matrix with a negative direction gets more on its diagonal
INDEFINITE = {"InteractionEllipsoidForceField"}


def dimension(unit):
    total, sign = numpy.zeros(3, int), 1
    for word in unit.replace("/", " / ").replace("(", " ").replace(")", " ").split():
        if word == "/":
            sign = -1
            continue
        name, _, power = word.partition("^")
        total += sign * int(power or 1) * numpy.array(BASE[name])
    return tuple(int(number) for number in total)


def factor(of, units):
    return float(numpy.prod(numpy.array(units, float) ** numpy.array(of, float)))


def below(node):
    yield node
    for child in node.children:
        yield from below(child)


def dimensions_of(component, name, frames):
    """Those of the numbers of an attribute one after the other, again and again; none where it has no numbers with a unit."""
    attribute = stroma.type_info(component.type).find(name)
    if component.type in ("CableConstraint", "PositionConstraint") and name == "value":
        return [LENGTH]
    if component.type == "SurfacePressureConstraint" and name == "value":
        return [(3, 0, 0)] if component.given("valueType") == "volumeGrowth" else [(-1, 1, -2)]
    if name in ("stiffness", "damping") and attribute is None:  # shorthands of springs
        return [(0, 1, -2) if name == "stiffness" else (0, 1, -1)]
    if attribute is None or attribute.link or attribute.file or attribute.words:
        return []
    if name in MIXED:
        return MIXED[name]
    if name == "ParameterSet":
        return [(-1, 1, -2)]
    if frames and name in OF_FRAMES and "Topology" not in component.type:
        return OF_FRAMES[name]
    unit = attribute.unit.partition(" or ")[0]
    return [dimension(unit)] if unit not in ("", "-") else []


def scaled(text, units):
    """The scene with all its numbers in units of which one is as many of the page's."""
    root = stroma.from_xml_text(text)
    for name, of, usual in (("dt", (0, 0, 1), "0.01"), ("gravity", (1, 0, -2), "0 -9.81 0")):
        numbers = numpy.array(str(root.given(name) or usual).split(), float) * factor(of, units)
        setattr(root, name, " ".join(repr(float(number)) for number in numbers))
    for node in below(root):
        states = [component for component in node.components if component.type == "MechanicalObject"]
        frames = any(state.given("template") == "Rigid3" for state in states)
        for component in node.components:
            for name, value in list(component.attributes.items()):
                of = dimensions_of(component, name, frames)
                if of and not str(value).startswith("@"):
                    numbers = [float(word) for word in str(value).replace(",", " ").split()]
                    component.set(name, " ".join(repr(number * factor(of[i % len(of)], units)) for i, number in enumerate(numbers)))
    return root


def numbers_of(simulation):
    """Every number with a unit that a run leaves: what, in which dimension, and the values."""
    for state in simulation.states():
        for what, of in (("x", LENGTH), ("v", SPEED)):
            values = numpy.array(getattr(state, what))
            if values.shape[1] == 3:
                yield f"{state.path} {what}", of, values
            else:
                yield f"{state.path} {what} of centres", of, values[:, :3]
                yield f"{state.path} {what} of turns", NUMBER if what == "x" else TURN, values[:, 3:]
    for component in simulation.components():
        info = stroma.type_info(component.type)
        if info.role == "engine":  # lists of frames and matrices
            continue
        for attribute in info.attributes:
            has_unit = attribute.unit and " or " not in attribute.unit
            if attribute.output and has_unit and attribute.name not in ("graph", "reset_position"):
                values = numpy.asarray(component.get(attribute.name), float)
                yield f"{component.path}.{attribute.name}", dimension(attribute.unit), values


def run(text, units):
    simulation = stroma.load(scaled(text, units), observers=False, quiet=True)
    simulation.run(3, check=False)
    return {what: (of, values) for what, of, values in numbers_of(simulation)}


# the last are about gigametres with 0.01 s, and nanometres with a gravity of 8e-15
@pytest.mark.parametrize("units", [(2.0 ** 12, 2.0 ** 18, 2.0 ** 6), (2.0 ** -12, 2.0 ** -18, 2.0 ** -6),
                                   (2.0 ** 30, 2.0 ** 40, 2.0 ** -7), (2.0 ** -30, 2.0 ** -80, 2.0 ** 10)])
def test_examples_have_the_same_numbers_in_other_units(units, folder):
    compared, exact, wrong = 0, 0, []
    for type in sorted(stroma.types()):
        example = EXAMPLE.search(stroma.type_info(type).manual)
        text = example.group(1) if example else ""
        named = set(re.findall(r"<(\w+)", text))
        if not text or named & (UNTOLD | BY_DEFAULT | INDEFINITE) or re.search('template="Vec|filename=', text):
            continue
        mixed = "Rigid3" in text  # iterations and thresholds add squares of metres and radians
        if mixed and abs(math.log2(units[0])) > 20:
            continue
        as_written = run(text, (1, 1, 1))
        for what, (of, values) in run(text, units).items():
            expected = as_written[what][1]
            if mixed and what.endswith((".residualGraph", ".factorisations")):
                continue
            back = values / factor(of, units)
            if mixed and back.shape == expected.shape:
                same = numpy.allclose(back, expected, rtol=1e-7, atol=1e-7 * numpy.abs(expected).max(initial=0))
            else:
                same = numpy.array_equal(back, expected, equal_nan=True)
            if not same:
                wrong.append(f"{type}: {what}: {back.ravel()[:3]} for {expected.ravel()[:3]}")
        compared += 1
        exact += not mixed
    assert not wrong, "\n".join(wrong)
    assert exact > 90 and (compared > 120 or abs(math.log2(units[0])) > 20), (compared, exact)
