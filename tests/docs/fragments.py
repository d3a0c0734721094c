# SPDX-License-Identifier: LGPL-2.1-or-later
"""A fragment of a scene put into a whole one, so that it can be checked."""
import re
import xml.etree.ElementTree as xml

WHOLE = re.compile(r"^\s*(?:<\?xml.*?\?>|<!--.*?-->|\s)*<Node\b(?P<attributes>[^>]*)>.*</Node>\s*$", re.S)


class FragmentError(Exception):
    """A fragment that cannot be put anywhere."""


def is_whole(text, title):
    """Is it a scene of its own: one node from end to end. One with a title but without gravity and time step is a part that
    other scenes include."""
    match = WHOLE.match(text)
    return bool(match) and (not title or bool(re.search(r"\b(gravity|dt)=", match.group("attributes"))))


def _twin(host, part):
    """(parent, element) of what the part takes the place of, or None."""
    for parent in host.iter("Node"):
        for child in parent:
            names = child.get("name"), part.get("name")
            if child.tag == part.tag and child.tag != "Node" and (None in names or names[0] == names[1]):
                return parent, child
            if child.tag == part.tag == "Node" and names[0] == names[1] is not None:
                return parent, child
    return None


def put(fragment, scene):
    """The text of `scene` with the components of `fragment`."""
    try:
        parts = xml.fromstring(f"<fragment>{fragment}</fragment>")
    except xml.ParseError as error:
        raise FragmentError(f"this is no XML: {error}") from error
    host = xml.fromstring(scene)
    bodies = [node for node in host.iter("Node") if node.find("MechanicalObject") is not None]
    for part in list(parts):
        twin = _twin(host, part)
        if twin:
            parent, old = twin
            place = list(parent).index(old)
            if old.get("name") and not part.get("name"):  # others may link to it
                part.set("name", old.get("name"))
            parent.remove(old)
            parent.insert(place, part)
        else:
            (host if part.tag == "Node" or not bodies else bodies[-1]).append(part)
    return xml.tostring(host, encoding="unicode")
