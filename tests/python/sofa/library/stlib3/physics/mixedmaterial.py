# SPDX-License-Identifier: LGPL-2.1-or-later
"""Bodies of which parts are rigid."""


def Rigidify(targetObject, sourceObject, groupIndices, frames, name=None):
    """Nodes of groupIndices follow frames; the others stay free; the body follows both."""
    if name is None:
        name = sourceObject.name
    ero = targetObject.addChild(name)
    allPositions = sourceObject.container.position
    allIndices = list(range(len(allPositions)))
    selected, indicesMap, rigids = [], [], []
    for number, (group, frame) in enumerate(zip(groupIndices, frames)):
        points = [allPositions[i] for i in group]
        rigids.append(list(sum(points) / len(points)) + list(frame))
        selected += list(group)
        indicesMap += [number] * len(group)
    others = list(filter(lambda x: x not in selected, allIndices))
    pairs = {v: None for v in allIndices}
    pairs.update({v: [0, k] for k, v in enumerate(others)})
    pairs.update({v: [1, k] for k, v in enumerate(selected)})
    free = ero.addChild("DeformableParts")
    free.addObject("MechanicalObject", template="Vec3", name="dofs", position=[list(allPositions[i]) for i in others])
    rigid = ero.addChild("RigidParts")
    rigid.addObject("MechanicalObject", template="Rigid3", name="dofs", reserve=len(rigids), position=rigids)
    particles = rigid.addChild("RigidifiedParticules")
    particles.addObject("MechanicalObject", template="Vec3", name="dofs", position=[list(allPositions[i]) for i in selected])
    particles.addObject("RigidMapping", name="mapping", globalToLocalCoords=True, rigidIndexPerPoint=indicesMap)
    sourceObject.removeObject(sourceObject.solver)
    sourceObject.removeObject(sourceObject.integration)
    sourceObject.removeObject(sourceObject.correction)
    sourceObject.addObject("SubsetMultiMapping", name="mapping", template="Vec3,Vec3",
                           input=[free.dofs.getLinkPath(), particles.dofs.getLinkPath()], output=sourceObject.dofs.getLinkPath(),
                           indexPairs=[v for pair in pairs.values() for v in pair])
    particles.addChild(sourceObject)
    free.addChild(sourceObject)
    return ero
