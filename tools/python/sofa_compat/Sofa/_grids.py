# SPDX-License-Identifier: LGPL-2.1-or-later
"""Edges, triangles and quads of grids, which SOFA's list from the start: here a scene has them where something reads them."""
import functools

from stroma import tree

from . import _values

LISTS = {"edges": "computeEdgeList", "triangles": "computeTriangleList", "quads": "computeQuadList"}
_SIZES = ("n", "nx", "ny", "nz", "min", "max", "xmin", "xmax", "ymin", "ymax", "zmin", "zmax", "cellWidth", *LISTS.values())


def list_of(grid, name):
    """As SOFA numbers them."""
    given = {each: grid.findData(each) for each in _SIZES if grid.findData(each) is not None and grid.findData(each).isSet()}
    found = _lists(tuple((each, _values.to_text(data.value)) for each, data in given.items()))[name]
    return found[:0] if LISTS[name] in given and not given[LISTS[name]].value else found


@functools.lru_cache(maxsize=4)
def _lists(sizes):
    root = tree.Node("grids", strict=False, dialect="sofa")
    grid = root.add("RegularGridTopology", name="grid", **{**{flag: True for flag in LISTS.values()}, **dict(sizes)})
    preview = root.preview()
    return {name: preview.get(grid.path, name) for name in LISTS}
