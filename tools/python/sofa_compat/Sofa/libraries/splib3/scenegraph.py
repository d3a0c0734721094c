# SPDX-License-Identifier: LGPL-2.1-or-later
"""Nodes, objects and data by paths."""


def find(node, path):
    """By a path that begins with the name of its node, as /scene/body/dofs; None where it leads nowhere."""
    first, *others = path.split("/")[1:]
    if first != str(node.name.value):
        return None
    for name in others:
        node = node.getChild(name) or node.getObject(name) if node is not None else None
    return node


def get(node, path):
    """By a path from this node, as body/dofs.position."""
    if path.startswith(("/", "../")):
        raise Exception(f"the path '{path}' does not begin in {node.getLinkPath()}")
    here = node
    for part in path[2 * path.startswith("./"):].split("/"):
        name, _, data = part.partition(".")
        found = here.getChild(name) or here.getObject(name) or here.getData(name)
        found = found.getData(data) if data and found is not None else found
        if found is None:
            raise Exception(f"the path '{path}' of {node.getLinkPath()} leads nowhere")
        here = found
    return here


def getLinkPath(node, path):
    return get(node, path).getLinkPath()
