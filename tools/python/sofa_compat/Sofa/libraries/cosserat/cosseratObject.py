# SPDX-License-Identifier: LGPL-2.1-or-later
"""A rod by a dict cosseratGeometry and parameters of the prefab."""
import Sofa  # noqa: F401
from useful.utils import addEdgeCollision, addPointsCollision  # noqa: F401

from cosserat._rod import Rod
from cosserat.usefulFunctions import BuildCosseratGeometry, buildEdges, pluginList  # noqa: F401


def _solvers(parent):
    node = parent.addChild("solverNode")
    node.addObject("EulerImplicitSolver", rayleighStiffness=0.2, rayleighMass=0.1)
    node.addObject("SparseLDLSolver", name="solver", template="CompressedRowSparseMatrixd")
    node.addObject("GenericConstraintCorrection")
    return node


class Cosserat(Rod):
    prefabParameters = [{"name": name, "type": kind, "help": help, "default": default} for name, kind, help, default in (
        ("name", "string", "of the node", "Cosserat"), ("position", "Rigid3d::VecCoord", "of the foot", [[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]]),
        ("translation", "Vec3d", "of the foot", [0.0, 0.0, 0.0]), ("rotation", "Vec3d", "of the foot", [0.0, 0.0, 0.0]),
        ("youngModulus", "double", "of the rod", 1e6), ("poissonRatio", "double", "of the rod", 0.4),
        ("shape", "string", "of the section", "circular"), ("radius", "double", "of a circular section", 0.02),
        ("length_Y", "double", "of a rectangular section", 1.0), ("length_Z", "double", "of a rectangular section", 1.0),
        ("rayleighStiffness", "double", "damping over stiffness", 0.0), ("attachingToLink", "string", "1: a spring holds the foot", "1"),
        ("showObject", "string", "frames are seen", "0"))]

    def __init__(self, *args, **kwargs):
        self.cosseratGeometry, self.parent = kwargs.pop("cosseratGeometry"), kwargs.pop("parent", None)
        inertia = kwargs.pop("inertialParams", None)
        super().__init__(*args, **kwargs)
        self.beamMass, self.useInertiaParams = self.cosseratGeometry.get("beamMass", 0.0), inertia is not None
        self._find_solver(_solvers)
        bendings, ends, lengths, frames, along, self.frames3D = BuildCosseratGeometry(self.cosseratGeometry)
        value = lambda name: self.findData(name).value  # noqa: E731
        self.rigidBaseNode = self._add_foot([list(place) for place in value("position")],
                                            {name: list(value(name)) for name in ("translation", "rotation")}, int(value("showObject")),
                                            int(value("attachingToLink")))
        given = {**{name: inertia[name] for name in ("GI", "GA", "EI", "EA")}, "useInertiaParams": True} if inertia else {
            "youngModulus": value("youngModulus"), "poissonRatio": value("poissonRatio")}
        self.cosseratCoordinateNode = self._add_strains(bendings, {
            **given, "crossSectionShape": value("shape"), "length": lengths, "radius": value("radius"),
            "rayleighStiffness": value("rayleighStiffness"), "lengthY": value("length_Y"), "lengthZ": value("length_Z")})
        self.cosseratFrame = self._add_frames(frames, ends, along, self.beamMass, int(value("showObject")))
