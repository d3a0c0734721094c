# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the experiments compare: kinds of cell and variants (method, B updated, V updated) of the corotational elements."""

SUFFIXES = {"tetrahedra": "", "hexahedra": "_hexahedra"}  # of the scenes' names
METHODS = ("small", "large", "polar", "svd")
CONSTANT_B = [(method, 0, 0) for method in METHODS]
UPDATED_B = [(method, 1, 0) for method in METHODS[1:]]


def scene(path, cells):
    """The scene of this kind of cell: `path` is that of tetrahedra."""
    return path.replace(".xml", SUFFIXES[cells] + ".xml")


def settings(method, update_b, update_v, fem):
    """Overrides for the force field at the path `fem`."""
    return [f"{fem}.method={method}", f"{fem}.updateStiffnessMatrix={'true' if update_b else 'false'}",
            f"{fem}.updateVolume={'true' if update_v else 'false'}"]


def name(method, update_b, update_v):
    return method + (", B and V" if update_v else ", B" if update_b else "")
