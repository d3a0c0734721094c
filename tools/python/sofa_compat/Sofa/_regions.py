# SPDX-License-Identifier: LGPL-2.1-or-later
"""Edges, triangles and quads in a region, which SOFA's regions choose of all that a topology lists: here those lists are made where
somebody asks, so a region that nothing links to is computed once more with them."""
import functools
import re

import numpy as np
from stroma import tree

from . import _values

_OUTPUT = re.compile(r"(edge|triangle|quad)(Indices|IndicesOut|sInROI|sOutROI)$")


def lists(data_name):
    """The list of the topology that an output is chosen of; None for others."""
    found = _OUTPUT.match(data_name)
    return found[1] + "s" if found else None


def chosen(region, data_name):
    """The output with the lists of the topology around; None where it has none of them."""
    name = lists(data_name)
    topology = _topology_of(region)
    own = region.findData(name)
    if topology is None or (own is not None and own.isSet()):
        return None
    rows = np.asarray(topology.findData(name).value) if topology.findData(name) is not None else np.zeros(0)
    if not len(rows):
        return None
    given = {each._s_name: _values.to_text(each.value) for each in region.getDataFields() if _is_given(each)}
    places = region.findData("position")
    places = np.asarray(places.value) if places is not None and places.isSet() else _places_around(region, topology)
    attributes = {**given, "position": _values.to_text(places), name: _values.to_text(rows), "name": "region"}
    return _computed(region._s_type, tuple(sorted(attributes.items())), data_name)


@functools.lru_cache(maxsize=16)
def _computed(kind, attributes, data_name):
    root = tree.Node("regions", strict=False, dialect="sofa")
    return root.preview().get(root.add(kind, **dict(attributes)).path, data_name)


def _is_given(data):
    return data.isSet() and not data._s_name.startswith("_") and data._s_name not in (
        "name", "position", "src", "edges", "triangles", "quads", "tetrahedra", "hexahedra", "listening", "printLog", "tags")


def _nodes_above(region):
    node = region._s_node()
    while node is not None:
        yield node
        node = node._s_above()


def _of_role(node, role):
    return [each for each in node._s_objects if each._s_facts is not None and each._s_facts.role == role]


def _topology_of(region):
    """The last of its node, else the first of the nearest node above."""
    for node in _nodes_above(region):
        found = _of_role(node, "topology")
        if found:
            return found[-1] if node is region._s_node() else found[0]
    return None


def _places_around(region, topology):
    for node in _nodes_above(region):
        states = _of_role(node, "mechanical state")
        if states:
            return np.asarray(states[0].rest_position.value)[:, :3]
    return np.asarray(topology.position.value)
