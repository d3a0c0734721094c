# SPDX-License-Identifier: LGPL-2.1-or-later
"""Bodies of which parts are rigid."""
from Sofa import _libraries
from splib3.numerics import Quat

_libraries.same_module(__name__, "rigidification")


def getBarycenter(selectedPoints):
    return [sum(numbers) / len(selectedPoints) for numbers in zip(*selectedPoints)] if len(selectedPoints) else [0.0, 0.0, 0.0]


def _frame(frame, points):
    """Centre and quaternion: of angles in degrees or a quaternion, alone (about the middle of the points) or after a centre."""
    *centre, a, b, c = frame if len(frame) in (3, 6) else [*frame[:-4], 0, 0, 0]
    turn = Quat.createFromEuler([a, b, c], inDegree=True) if len(frame) in (3, 6) else frame[-4:]
    if len(frame) not in (3, 4, 6, 7):
        raise ValueError(f"a frame has 3, 4, 6 or 7 numbers: {frame}")
    return [*map(float, centre if centre else getBarycenter(points)), *map(float, turn)]


def Rigidify(targetObject, sourceObject, groupIndices, frames=None, name=None):
    """Nodes of groupIndices follow frames; the others stay free; the body follows both, by a mapping of two states."""
    frames = [[0.0, 0.0, 0.0]] * len(groupIndices) if frames is None else frames
    assert len(groupIndices) == len(frames), "there are as many frames as groups"
    whole = targetObject.addChild(name if name is not None else str(sourceObject.name.value))
    places = [list(map(float, place)) for place in sourceObject.container.position.value]
    held = [int(i) for group in groupIndices for i in group]
    taken = set(held)
    free = [i for i in range(len(places)) if i not in taken]
    pairs = {i: (0, k) for k, i in enumerate(free)}
    pairs.update({i: (1, k) for k, i in enumerate(held)})

    deformable = whole.addChild("DeformableParts")
    deformable.addObject("MechanicalObject", template="Vec3", name="dofs", position=[places[i] for i in free])
    rigid = whole.addChild("RigidParts")
    rigids = [_frame(list(frame), [places[i] for i in sorted(set(group))]) for group, frame in zip(groupIndices, frames)]
    rigid.addObject("MechanicalObject", template="Rigid3", name="dofs", reserve=len(rigids), position=rigids)
    particles = rigid.addChild("RigidifiedParticules")
    particles.addObject("MechanicalObject", template="Vec3", name="dofs", position=[places[i] for i in held])
    particles.addObject("RigidMapping", name="mapping", globalToLocalCoords=True,
                        rigidIndexPerPoint=[number for number, group in enumerate(groupIndices) for _ in group])

    for each in ("solver", "integration", "correction"):
        sourceObject.removeObject(getattr(sourceObject, each))
    sourceObject.addObject("SubsetMultiMapping", name="mapping", template="Vec3,Vec3",
                           input=[deformable.dofs.getLinkPath(), particles.dofs.getLinkPath()], output=sourceObject.dofs.getLinkPath(),
                           indexPairs=[number for i in range(len(places)) for number in pairs[i]])
    particles.addChild(sourceObject)
    deformable.addChild(sourceObject)
    return whole
