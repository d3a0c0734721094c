# SPDX-License-Identifier: LGPL-2.1-or-later
"""Values of data: what a scene may write (text, numbers, lists, arrays, objects, links), and what reading gives."""
import numbers
import os
import re

import numpy as np

#: numbers in a row of what SOFA keeps of each point, by the template of the component
COORDINATES = {"Vec1": 1, "Vec2": 2, "Vec3": 3, "Vec6": 6, "Rigid2": 3, "Rigid3": 7}
VELOCITIES = {"Vec1": 1, "Vec2": 2, "Vec3": 3, "Vec6": 6, "Rigid2": 3, "Rigid3": 6}

_TRUE = {"1", "true", "t", "yes", "on"}
_FALSE = {"0", "false", "f", "no", "off", ""}


def is_link_text(value):
    """Whether a value is a link as text: "@loader.position"."""
    return isinstance(value, str) and value.strip().startswith("@")


def links_in(text):
    """Each link of a text: from an @ at the start of a word to the next one, as names may have blanks."""
    return re.split(r"\s+(?=@)", text.strip())


def plain_template(template):
    """Vec3d and Vec3f are Vec3; of a pair the last counts: "Vec3,Rigid3" is Rigid3."""
    word = str(template or "").split(",")[-1].strip()
    older = {"Rigid": "Rigid3", "StdRigidTypes": "Rigid3", "StdVec3Types": "Vec3"}
    if word in older:
        return older[word]
    return word[:-1] if word[-1:] in ("d", "f") else word


def columns_of(template):
    """Of lists of values: "vector<Vec3d>" has rows of three numbers. None: of single numbers."""
    word = re.search("Rigid3|Vec[2346]", str(template or ""))
    return COORDINATES.get(word.group(), int(word.group()[-1])) if word else None


def _number_text(value):
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    return repr(float(value))


def to_text(value):
    """As an attribute of a scene file has it. Objects and data are links to them."""
    if isinstance(value, str):
        return value
    if isinstance(value, (bool, np.bool_, numbers.Number)):
        return _number_text(value)
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, np.ndarray):
        return " ".join(_number_text(each) for each in value.ravel().tolist())
    if hasattr(value, "getLinkPath"):
        return value.getLinkPath()
    if value is None:
        return ""
    if isinstance(value, dict):
        raise TypeError("a dictionary is no value of a data")
    try:
        return " ".join(to_text(each) for each in value)
    except TypeError:
        raise TypeError(f"a {type(value).__name__} is no value of a data") from None


def _words(text):
    for mark in "[](),;":
        text = text.replace(mark, " ")
    return text.split()


def _number(word):
    """A number at the start of a word, as a stream reads it, or None."""
    try:
        return float(word)
    except ValueError:
        return None


def numbers_of(value):
    """All numbers in a value, in order, up to the first word that is none."""
    if isinstance(value, np.ndarray):
        return value.ravel()
    if isinstance(value, (bool, np.bool_, numbers.Number)):
        return np.array([float(value)])
    if isinstance(value, (list, tuple)):
        try:
            array = np.array(value)
        except ValueError:  # rows of several lengths
            array = np.array("")
        if array.dtype.kind in "biuf":
            return array.ravel().astype(float)
    found = []
    for word in _words(to_text(value)):
        truth = word.lower()
        number = 1.0 if truth == "true" else 0.0 if truth == "false" else _number(word)
        if number is None:
            break
        found.append(number)
    return np.array(found, dtype=float)


def as_bool(value):
    if isinstance(value, str):
        word = value.strip().lower()
        if word in _TRUE or word in _FALSE:
            return word in _TRUE
        raise ValueError(f"'{value}' is neither true nor false")
    return bool(np.any(value))


def like(sample, value):
    """`value` in the form of `sample`, a value of the same attribute: its kind, and of arrays its columns and numbers."""
    if isinstance(sample, (bool, np.bool_)):
        return as_bool(value)
    if isinstance(sample, str):
        return to_text(value)
    if isinstance(sample, (int, np.integer)):
        found = numbers_of(value)
        return int(found[0]) if len(found) else int(sample)
    if isinstance(sample, (float, np.floating)):
        found = numbers_of(value)
        return float(found[0]) if len(found) else float(sample)
    if isinstance(sample, np.ndarray):
        found = np.array(numbers_of(value), dtype=sample.dtype if sample.dtype != bool else float)
        if sample.dtype == bool:
            found = found != 0
        if sample.ndim == 2 and sample.shape[1]:
            whole = len(found) // sample.shape[1] * sample.shape[1]
            return found[:whole].reshape(-1, sample.shape[1])
        return found
    if isinstance(sample, list):
        return value.split() if isinstance(value, str) else [to_text(each) for each in value]
    return value


def by_itself(value):
    """A value of which nothing else is known, as it is read back: lists of numbers as arrays."""
    if isinstance(value, (list, tuple)) and value:
        try:
            array = np.array(value)
        except ValueError:
            return list(value)
        return array if array.dtype.kind in "biuf" else list(value)
    return value


def flat(value):
    """The items of a list of lists."""
    for each in value:
        if isinstance(each, (list, tuple)):
            yield from flat(each)
        else:
            yield each


def copied(value):
    """A value that nobody else holds."""
    if isinstance(value, np.ndarray):
        return np.array(value)
    if isinstance(value, (list, tuple, range)) or hasattr(value, "__next__"):
        return [copied(each) for each in value]
    return value
