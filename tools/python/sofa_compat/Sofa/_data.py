# SPDX-License-Identifier: LGPL-2.1-or-later
"""The data of an object: a name and a value, which may be a link to other data."""
import numpy as np

from . import _values


class ValueArray(np.ndarray):
    """The array that `data.value` gives. Entries that are set in it are set in the data."""

    def __new__(cls, array, data):
        self = np.array(array).view(cls)
        self._s_data = data
        return self

    def __array_finalize__(self, other):
        self._s_data = getattr(other, "_s_data", None)
        # that of which it is a part; none: it is the whole, which does not hold itself, so that it ends with its last name
        self._whole = None if self._s_data is None else other if other._whole is None else other._whole

    def __setitem__(self, key, value):
        super().__setitem__(key, value)
        whole = self if self._whole is None else self._whole
        if self._s_data is not None and (whole is self or np.may_share_memory(self, whole)):
            self._s_data.value = np.array(whole)

    def __array_wrap__(self, array, context=None, return_scalar=False):
        # what is computed from it is an array of its own
        result = np.asarray(array)
        return result[()] if result.ndim == 0 else result

    def __reduce__(self):
        return np.asarray(self).__reduce__()


class _Real(np.float64):
    """A number that is also a row of one."""

    def __getitem__(self, key):
        return [float(self)][key]


class _Integer(np.int64):
    def __getitem__(self, key):
        return [int(self)][key]


class RowsOfOne(ValueArray):
    """A list of numbers as SofaPython has it, which gives rows of one: `value[0][0]` is what `value[0]` is since."""

    used = False  # by scenes of then

    def __getitem__(self, key):
        found = super().__getitem__(key)
        return found if isinstance(found, np.ndarray) else _Integer(found) if self.dtype.kind in "iu" else _Real(found)

    def __iter__(self):
        return (self[index] for index in range(len(self)))


class Writing:
    """`with data.writeable() as array:` an array of which every entry may be set; the data has it at the end."""

    def __init__(self, data):
        self._s_data, self._array = data, None

    def __enter__(self):
        self._array = np.array(self._s_data.value)
        return self._array

    def __exit__(self, kind, error, trace):
        if kind is None:
            try:
                self._s_data.value = self._array
            except ValueError:
                now = np.array(self._s_data.value)
                if now.ndim != 2 or self._array.ndim != 2 or not len(self._array) < len(now):
                    raise
                now[:len(self._array)] = self._array  # of a state that has got points meanwhile
                self._s_data.value = now
        return False

    def __getitem__(self, key):
        return self._s_data.value[key]

    def __setitem__(self, key, value):
        self._s_data.value[key] = value

    def __len__(self):
        return len(self._s_data)

    def __array__(self, dtype=None):
        return np.asarray(self._s_data.value, dtype=dtype)


class Data:
    """`object.data`: read and assigned by `.value`."""

    __slots__ = ("_s_owner", "_s_name", "_s_raw", "_s_sample", "_s_help", "_s_group", "_s_stamp", "_s_seen", "_s_flags", "__weakref__")

    def __init__(self, owner, name, raw=None, sample=None, help="", group=""):
        self._s_owner, self._s_name, self._s_raw, self._s_sample = owner, name, raw, sample
        self._s_help, self._s_group, self._s_stamp = help, group, 0
        self._s_seen, self._s_flags = None, ("persistent",)

    # ---- the value ----
    @property
    def value(self):
        value = self._s_owner._s_read(self)
        if isinstance(value, np.ndarray) and not isinstance(value, ValueArray):
            return RowsOfOne(value, self) if RowsOfOne.used and value.ndim == 1 and value.dtype.kind in "iuf" else ValueArray(value, self)
        return value

    @value.setter
    def value(self, value):
        if isinstance(value, Data):  # a value, not a link: links are made by setParent() or as an argument
            value = value.value
        self._s_stamp += 1
        self._s_owner._s_write(self, _values.copied(value))

    def array(self):
        return np.array(self.value)

    def writeable(self, *_):
        return Writing(self)

    writeableArray = writeable

    def toList(self):
        value = self.value
        return value.tolist() if isinstance(value, np.ndarray) else list(value)

    tolist = toList

    def getValue(self, index=None):
        return self.value if index is None else np.ravel(self.value)[index]

    def setValue(self, *arguments):
        self.value = arguments[0] if len(arguments) == 1 else list(arguments)

    def read(self, text):
        """From text, as a scene file has it. False when it is none of this kind."""
        sample = self._s_owner._s_read(self)
        if isinstance(sample, (bool, int, float)) and not isinstance(sample, str) and not len(_values.numbers_of(str(text))):
            return False
        self.value = text
        return True

    def getValueString(self):
        value = self.value
        if isinstance(value, np.ndarray) and value.dtype.kind == "f":
            return " ".join(f"{each:.10g}" for each in value.ravel())
        return f"{value:.10g}" if isinstance(value, float) else _values.to_text(value)

    def getValueTypeString(self):
        value = self.value
        if isinstance(value, np.ndarray):
            kind = {"i": "int", "u": "int", "b": "bool"}.get(value.dtype.kind, "double")
            return f"vector<Vec{value.shape[1]}d>" if value.ndim == 2 and kind == "double" else f"vector<{kind}>"
        words = {bool: "bool", int: "int", float: "double", str: "string", list: "vector<string>"}
        return words.get(type(value), type(value).__name__)

    def getSize(self):
        return len(self)

    size = getSize

    # ---- links ----
    def setParent(self, other, *_):
        """From now on the value is that of `other`: data, or the path of one."""
        source = other
        while isinstance(source, Data):
            if source is self:
                raise ValueError(f"{self.getPathName()} cannot take its value from {other.getPathName()}, which takes its own from there")
            source = source.getParent()
        self._s_stamp += 1
        self._s_owner._s_write(self, other if isinstance(other, Data) or other is None else _as_link(other))

    setLinkPath = setParent

    def getLinkedPath(self, *_):
        parent = self.getParent()
        return parent.getLinkPath() if parent is not None else str(_values.to_text(self._s_raw))

    def getLinkedBase(self, *_):
        """The object or the node that it leads to; None: it is no link."""
        raw = self._s_raw
        if isinstance(raw, Data):
            return raw.getOwner()
        target = self._s_owner._s_linked(raw, self._s_name) if _values.is_link_text(raw) else raw
        return target.getOwner() if isinstance(target, Data) else target if hasattr(target, "getLinkPath") else None

    def setLinkedBase(self, target, *_):
        self.value = target

    def getLinkedData(self, *_):
        return self.getParent()

    def isMultiLink(self):
        return isinstance(self._s_raw, (list, tuple)) and len(self._s_raw) > 1

    def getOwnerBase(self):
        return self._s_owner

    def getParent(self):
        raw = self._s_raw
        if isinstance(raw, Data):
            return raw
        if _values.is_link_text(raw):
            target = self._s_owner._s_linked(raw, self._s_name)
            return target if isinstance(target, Data) else None
        return None

    def hasParent(self):
        return self.getParent() is not None

    def getLinkPath(self):
        return "@" + self.getPathName()

    @property
    def linkpath(self):
        from ._base import link_path_of

        return link_path_of(self)

    def getPathName(self):
        return f"{self._s_owner.getPathName()}.{self._s_name}"

    def getAsACreateObjectParameter(self):
        return self.getLinkPath()

    # ---- what it is ----
    def getName(self):
        return self._s_name

    def setName(self, name):
        owner = self._s_owner
        owner._s_data[str(name)] = owner._s_data.pop(self._s_name, self)
        self._s_name = str(name)

    def setHelp(self, text):
        self._s_help = str(text)

    name = property(getName)

    def getOwner(self):
        return self._s_owner

    def getHelp(self):
        return self._s_help

    help = property(getHelp)

    def getGroup(self):
        return self._s_group

    def isSet(self):
        return self._s_raw is not None

    def unset(self):
        self._s_owner._s_write(self, None)

    def isDirty(self):
        """A value that comes from other data is that of now, whenever it is read."""
        return False

    def hasChanged(self):
        """Whether the data that give it its value have another one than when this was asked before."""
        source = self.getParent()
        if source is None:
            return False
        from ._objects import _stamp

        before, self._s_seen = self._s_seen, (self._s_stamp, _stamp(source))
        return before != self._s_seen

    def isRequired(self):
        return False

    def _s_flag(self, word, on):
        self._s_flags = tuple(each for each in self._s_flags if each != word) + ((word,) if on else ())

    def isReadOnly(self):
        return "read only" in self._s_flags

    def setReadOnly(self, on=True):
        """A word for SOFA's windows: programs may write it all the same."""
        self._s_flag("read only", on)

    def isPersistent(self):
        return "persistent" in self._s_flags

    def setPersistent(self, on=True):
        self._s_flag("persistent", on)

    def updateIfDirty(self):
        """See isDirty()."""

    update = updateIfDirty

    def getCounter(self):
        return self._s_stamp

    def typeName(self):
        return self.getValueTypeString()

    # ---- as its value ----
    def __len__(self):
        return len(self.value)

    def __iter__(self):
        return iter(self.value)

    def __getitem__(self, key):
        return self.value[key]

    def __setitem__(self, key, value):
        whole = self.value
        if isinstance(whole, np.ndarray):
            whole = np.array(whole)
        whole[key] = value
        self.value = whole

    def __contains__(self, item):
        return item in self.value

    def __array__(self, dtype=None):
        return np.asarray(self.value, dtype=dtype)

    def __bool__(self):
        value = self.value
        return bool(len(value)) if hasattr(value, "__len__") else bool(value)

    def __float__(self):
        return float(self.value)

    def __int__(self):
        return int(self.value)

    def __index__(self):
        return self.value.__index__()

    def __str__(self):
        value = self.value
        return value if isinstance(value, str) else str(np.asarray(value)) if isinstance(value, np.ndarray) else str(value)

    def __format__(self, form):
        return format(str(self) if isinstance(self.value, np.ndarray) else self.value, form)

    def __repr__(self):
        return f"<Sofa.Core.Data {self.getPathName()}>"

    def __eq__(self, other):
        if other is None or isinstance(other, Data):
            return self is other
        return self.value == other

    def __ne__(self, other):
        if other is None or isinstance(other, Data):
            return self is not other
        return self.value != other

    def __hash__(self):
        return id(self)

    def __add__(self, other):
        return _operand(self) + _operand(other)

    def __radd__(self, other):
        return _operand(other) + _operand(self)

    def __sub__(self, other):
        return _operand(self) - _operand(other)

    def __rsub__(self, other):
        return _operand(other) - _operand(self)

    def __mul__(self, other):
        return _operand(self) * _operand(other)

    __rmul__ = __mul__

    def __truediv__(self, other):
        return _operand(self) / _operand(other)

    def __rtruediv__(self, other):
        return _operand(other) / _operand(self)

    def __neg__(self):
        return -_operand(self)

    def __lt__(self, other):
        return _operand(self) < _operand(other)

    def __le__(self, other):
        return _operand(self) <= _operand(other)

    def __gt__(self, other):
        return _operand(self) > _operand(other)

    def __ge__(self, other):
        return _operand(self) >= _operand(other)

    def __call__(self, *_, **__):
        if self._s_name == "size":
            return self._s_owner.getSize()
        raise AttributeError(f"{self._s_owner._s_place()}: {self._s_owner.getClassName()} has no '{self._s_name}()' here")

    def __getattr__(self, name):
        # SOFA's strings and lists answer what their values answer: data.split(), data.shape
        if name.startswith("_"):
            raise AttributeError(name)
        value = self.value
        if hasattr(value, name):
            return getattr(value, name)
        raise AttributeError(f"{self._s_owner._s_place()}: the data '{self._s_name}' has no '{name}'")


def _operand(value):
    if isinstance(value, Data):
        value = value.value
    if isinstance(value, (list, tuple)):
        return np.array(value)
    return value


def _as_link(other):
    if hasattr(other, "getLinkPath"):
        return other.getLinkPath()
    text = str(other)
    return text if text.startswith("@") else "@" + text


class DataString(Data):
    """Text."""

    __slots__ = ()


class DataContainer(Data):
    """A list or an array."""

    __slots__ = ()


class DataVectorString(DataContainer):
    """A list of words."""

    __slots__ = ()


class DataBox(DataContainer):
    """A box: its lower and its upper corner."""

    __slots__ = ()

    def _s_corner(self, index):
        value = self.value
        return [0.0, 0.0, 0.0] if value is None else np.reshape(value, (2, 3))[index].tolist()

    def getMin(self):
        return self._s_corner(0)

    def getMax(self):
        return self._s_corner(1)

    def getCenter(self):
        return [(low + high) / 2 for low, high in zip(self.getMin(), self.getMax())]

    def setMin(self, corner):
        self.value = [list(corner), self.getMax()]

    def setMax(self, corner):
        self.value = [self.getMin(), list(corner)]


class DataDict(dict):
    """The data of an object by their names."""

    def __getattr__(self, name):
        try:
            return self[name]
        except KeyError:
            raise AttributeError(name) from None


def made(owner, name, raw=None, sample=None, help="", group=""):
    """Data of the class that SOFA has for its kind."""
    like = sample if sample is not None else raw
    kind = Data
    if name == "bbox":
        kind = DataBox
    elif isinstance(like, str):
        kind = DataString
    elif isinstance(like, (list, tuple, np.ndarray)):
        words = isinstance(like, (list, tuple)) and (not like if sample is not None else bool(like) and isinstance(like[0], str))
        kind = DataVectorString if words else DataContainer
    return kind(owner, name, raw, sample, help, group)
