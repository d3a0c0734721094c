# SPDX-License-Identifier: LGPL-2.1-or-later
"""Types by attribute: root.addObject(Sofa.Components.MechanicalObject, name="dofs")."""


def __getattr__(name):
    if name.startswith("_"):
        raise AttributeError(name)

    def add(node, **values):
        return node.addObject(name, **values)

    add.__name__ = add.__qualname__ = name
    return add
