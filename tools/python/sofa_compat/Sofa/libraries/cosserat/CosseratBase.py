# SPDX-License-Identifier: LGPL-2.1-or-later
"""A rod by useful.params.Parameters."""
import Sofa  # noqa: F401
from useful.geometry import CosseratGeometry
from useful.header import addSolverNode
from useful.params import Parameters

from cosserat._rod import Rod


class CosseratBase(Rod):
    prefabParameters = [
        {"name": "name", "type": "string", "help": "of the node", "default": "Cosserat"},
        {"name": "translation", "type": "Vec3d", "help": "of the foot", "default": [0.0, 0.0, 0.0]},
        {"name": "rotation", "type": "Vec3d", "help": "of the foot", "default": [0.0, 0.0, 0.0]},
        {"name": "attachingToLink", "type": "string", "help": "1: a spring holds the foot", "default": "1"},
        {"name": "showObject", "type": "string", "help": "frames are seen", "default": "0"}]

    def __init__(self, *args, **kwargs):
        self.params, self.parent = kwargs.pop("params", None) or Parameters(), kwargs.pop("parent", None)
        super().__init__(*args, **kwargs)
        physics, self.beam_params = self.params.beam_physics_params, self.params.beam_geo_params
        self.beamMass, self.radius, self.useInertiaParams = physics.beam_mass, physics.beam_radius, physics.use_inertia
        self._find_solver(addSolverNode)
        geometry = CosseratGeometry(self.beam_params)
        self.frames3D, shown = geometry.cable_positionF, self.beam_params.show_frames_object
        self.rigidBaseNode = self._add_foot([[*self.beam_params.init_pos, 0.0, 0.0, 0.0, 1.0]],
                                            {name: list(self.findData(name).value) for name in ("translation", "rotation")}, shown,
                                            int(self.attachingToLink.value))
        self.cosseratCoordinateNode = self._add_strains(geometry.bendingState, self._elasticity(physics, geometry.sectionsLengthList))
        self.cosseratFrame = self._add_frames(geometry.framesF, geometry.curv_abs_inputS, geometry.curv_abs_outputF, self.beamMass, shown)

    def _elasticity(self, physics, lengths):
        given = {"GI": physics.GI, "GA": physics.GA, "EI": physics.EI, "EA": physics.EA, "useInertiaParams": True} if physics.use_inertia else {
            "youngModulus": physics.young_modulus, "poissonRatio": physics.poisson_ratio}
        return {**given, "crossSectionShape": physics.beam_shape, "length": lengths, "radius": physics.beam_radius,
                "rayleighStiffness": self.params.simu_params.rayleigh_stiffness, "lengthY": physics.length_y, "lengthZ": physics.length_z}
