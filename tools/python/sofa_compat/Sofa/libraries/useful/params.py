# SPDX-License-Identifier: LGPL-2.1-or-later
"""Parameters of a rod. Scenes write them as the plugin has them now (beam_length) or as it had them (beamLength)."""
import re
from copy import copy


def _present(name):
    """beamLength, length_Y, nbSection: beam_length, length_y, nb_section. The four stiffnesses keep their names."""
    return name if name in ("GI", "GA", "EI", "EA") else re.sub(r"(?<=[a-z])([A-Z])", r"_\1", name).lower()


class _Numbers:
    """Values by name, with a default each."""

    _defaults = {}

    def __init__(self, *values, **named):
        for name, value in self._defaults.items():
            setattr(self, name, value() if isinstance(value, type) else copy(value))
        if len(values) > len(self._defaults):
            raise TypeError(f"{type(self).__name__} takes {len(self._defaults)} values, and {len(values)} are given")
        for name, value in [*zip(self._defaults, values), *named.items()]:
            if _present(name) not in self._defaults:
                raise TypeError(f"{type(self).__name__} has no '{name}': it has {', '.join(self._defaults)}")
            setattr(self, name, value)

    def __setattr__(self, name, value):
        object.__setattr__(self, _present(name), value)

    def __getattr__(self, name):
        present = _present(name)
        if name.startswith("__") or present == name:
            raise AttributeError(f"{type(self).__name__} has no '{name}'")
        return getattr(self, present)

    def __repr__(self):
        return f"{type(self).__name__}({', '.join(f'{name}={getattr(self, name)!r}' for name in self._defaults)})"


class BeamGeometryParameters(_Numbers):
    _defaults = {"beam_length": 1.0, "nb_section": 5, "nb_frames": 30, "build_collision_model": 0, "init_pos": [0.0, 0.0, 0.0],
                 "show_frames_object": True, "show_frames_indices": False, "show_rigid_base_object": 1}


class BeamPhysicsParameters(_Numbers):
    _defaults = {"young_modulus": 1.205e8, "poisson_ratio": 0.3, "beam_mass": 1.0, "beam_radius": 0.01, "beam_length": 1.0,
                 "beam_shape": "circular", "length_y": 0.1, "length_z": 0.1, "use_inertia": False, "GI": 1.5708, "GA": 3.1416e4, "EI": 0.7854,
                 "EA": 3.1416e4}


BeamPhysicsBaseParameters = BeamPhysicsParametersNoInertia = BeamPhysicsParameters


class BeamPhysicsParametersWithInertia(BeamPhysicsParameters):
    _defaults = {**BeamPhysicsParameters._defaults, "use_inertia": True}


class SimulationParameters(_Numbers):
    _defaults = {"rayleigh_stiffness": 0.2, "rayleigh_mass": 0.1, "first_order": False}


class VisualParameters(_Numbers):
    _defaults = {"show_object": 1, "show_object_scale": 1.0, "show_object_color": [1.0, 0.0, 0.0, 1.0]}


class ContactParameters(_Numbers):
    _defaults = {"response_params": "mu=0.0", "response": "FrictionContactConstraint", "alarm_distance": 0.05, "contact_distance": 0.01,
                 "is_multithreading": False, "tolerance": 1e-8, "max_iterations": 100, "epsilon": 1e-6}


class Parameters(_Numbers):
    _defaults = {"beam_physics_params": BeamPhysicsParameters, "simu_params": SimulationParameters, "contact_params": ContactParameters,
                 "beam_geo_params": BeamGeometryParameters, "visual_params": VisualParameters}
