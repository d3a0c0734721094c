# SPDX-License-Identifier: LGPL-2.1-or-later
"""One scene in every form that SOFA's Python takes a value, a template or a link in: the same movement."""
import functools

import numpy as np
import pytest
import Sofa

PLACES = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
TEXT = "0 0 0  1 0 0  0 1 0  0 0 1"


def moved(body=None, root=None, after=None, **other):
    """Positions after five steps of a tetrahedron on three nodes; `other`: attributes as component_attribute."""
    top = Sofa.Core.Node("root")
    top.gravity, top.dt = [0, -10, 0], 0.01
    if root is not None:
        root(top)
    node = top.addChild("body")
    given = {"topo_position": PLACES, "topo_tetrahedra": [[0, 1, 2, 3]], "dofs_template": "Vec3d", "mass_totalMass": 4.0,
             "fem_youngModulus": 1000, "fem_poissonRatio": 0.3, "fix_indices": [0, 1, 2], "load_indices": [3], "load_totalForce": [1, 2, 3],
             "lin_template": "CompressedRowSparseMatrixMat3x3d", "ode_rayleighStiffness": 0.1, **other}
    for name, kind in (("ode", "EulerImplicitSolver"), ("lin", "SparseLDLSolver"), ("topo", "TetrahedronSetTopologyContainer"),
                       ("dofs", "MechanicalObject"), ("mass", "UniformMass"), ("fem", "TetrahedronFEMForceField"),
                       ("fix", "FixedProjectiveConstraint"), ("load", "ConstantForceField")):
        node.addObject(kind, name=name, **{key[len(name) + 1:]: value for key, value in given.items() if key.startswith(name + "_")})
    if body is not None:
        body(node)
    Sofa.Simulation.init(top)
    if after is not None:
        after(node)
    for _ in range(5):
        Sofa.Simulation.animate(top, top.dt.value)
    return np.array(node.dofs.position.value)


@functools.lru_cache
def usual():
    return moved()


def array(*given):
    return np.array(*given)


FORMS = {
    "topo_position": [array(PLACES, float), array(PLACES), tuple(map(tuple, PLACES)), [array(each) for each in PLACES], TEXT,
                      "0,0,0 1,0,0 0,1,0 0,0,1", "0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1", array(PLACES).ravel(), array(PLACES).ravel().tolist(),
                      array(PLACES, np.float32), [[str(x) for x in each] for each in PLACES], "[[0,0,0],[1,0,0],[0,1,0],[0,0,1]]",
                      TEXT.replace("  ", "\n"), TEXT.replace("0", "0.")],
    "topo_tetrahedra": [array([[0, 1, 2, 3]]), [0, 1, 2, 3], "0 1 2 3", "0,1,2,3", ((0, 1, 2, 3),), array([[0, 1, 2, 3]], np.uint32),
                        [[0., 1., 2., 3.]], "[0 1 2 3]"],
    "dofs_template": ["Vec3", "Vec3f", "ExtVec3d", "ExtVec3f", "ExtVec3", ""],
    "dofs_position": ["@topo.position", "@./topo.position", "@../body/topo.position", "@/body/topo.position", "@[-1].position"],
    "dofs_src": ["@topo", "@[-1]"],
    "dofs_topology": ["@topo", "@./topo", "@[-1]"],
    "dofs_showObject": [True, "1", 1, "true", "True", np.bool_(1)],
    "fem_template": ["Vec3", "Vec3d", "Vec3f", "ExtVec3f", "", None],
    "fem_computeGlobalMatrix": [0, 1, "0", "false", "False", False, "true", True, "True", "1", [False]],
    "lin_template": ["CompressedRowSparseMatrixd", "CompressedRowSparseMatrix", "CompressedRowSparseMatrix3d",
                     "CompressedRowSparseMatrix<Mat3x3d>", ""],
    "mass_totalMass": [4, "4", " 4.0 ", np.float64(4), np.float32(4), [4], array([4.]), array(4.), "4e0", np.int64(4)],
    "fem_youngModulus": ["1000", [1000], array([1000.]), "1e3", np.float64(1000), (1000,)],
    "fem_poissonRatio": ["0.3", [0.3], array([0.3]), ".3", "+0.3"],
    "fix_indices": ["0 1 2", "0,1,2", array([0, 1, 2]), (0, 1, 2), range(3), {0, 1, 2}, [0., 1., 2.], "[0,1,2]", [[0, 1, 2]], [[0], [1], [2]],
                    ["0", "1", "2"], "0-2", array([0, 1, 2], np.uint8), "0\n1\n2"],
    "load_totalForce": [array([1., 2, 3]), (1, 2, 3), [[1, 2, 3]], "1,2,3", [np.float64(1), 2, 3], "[1,2,3]", "1.0 2.0 3.0"],
}


@pytest.mark.parametrize("name, form", [pytest.param(name, form, id=f"{name}-{k}") for name, forms in FORMS.items()
                                        for k, form in enumerate(forms)])
def test_a_value_in_another_form(name, form):
    assert moved(**{name: form}) == pytest.approx(usual(), abs=1e-12)


def _set(name, value):
    """thing.name = value, and the other ways."""
    return [lambda thing: setattr(thing, name, value), lambda thing: setattr(thing.findData(name), "value", value),
            lambda thing: setattr(thing.getData(name), "value", value), lambda thing: thing.findData(name).setValue(value),
            lambda thing: thing.setDataValues(**{name: value})]


SET = [("root", way) for value in ("0 -10 0", array([0, -10, 0]), (0, -10., 0)) for way in _set("gravity", value)[:4]]
SET += [("root", way) for value in (0.01, "0.01") for way in _set("dt", value)[:4]]
SET += [("root", lambda root: root.setGravity([0, -10, 0])), ("root", lambda root: root.setDt(0.01))]
for when in ("body", "after"):
    for component, data, value in (("fem", "youngModulus", [1000.]), ("fem", "youngModulus", 1000), ("load", "totalForce", [1, 2, 3]),
                                   ("fix", "indices", [0, 1, 2]), ("mass", "totalMass", 4)):
        SET += [(when, lambda node, c=component, way=way: way(node.getObject(c))) for way in _set(data, value)]
SET += [("after", lambda node, way=way: way(node.dofs)) for value in (PLACES, array(PLACES, float), TEXT) for way in _set("position", value)]


@pytest.mark.parametrize("when, way", [pytest.param(*each, id=str(k)) for k, each in enumerate(SET)])
def test_a_value_that_is_set(when, way):
    assert moved(**{when: way}) == pytest.approx(usual(), abs=1e-12)
