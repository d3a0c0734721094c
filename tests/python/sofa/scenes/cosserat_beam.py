# SPDX-License-Identifier: LGPL-2.1-or-later
"""A Cosserat beam as its plugin's tutorials write it: a base, curvatures with Hooke's law, and frames that are mapped from both."""
from dataclasses import dataclass

import numpy as np

stiffness_param = 1.e10
beam_radius = 1.


@dataclass
class BeamGeometryParameters:
    beam_length: float = 30.
    nb_section: int = 6
    nb_frames: int = 12
    build_collision_model: int = 0


def _add_rigid_base(p_node, positions=None):
    positions = [0, 0, 0, 0, 0, 0, 1] if positions is None else positions
    rigid_base_node = p_node.addChild('rigid_base')
    rigid_base_node.addObject('MechanicalObject', template='Rigid3d', name="cosserat_base_mo", position=positions, showObject=True,
                              showObjectScale='0.1')
    rigid_base_node.addObject('RestShapeSpringsForceField', name='spring', stiffness=stiffness_param, angularStiffness=stiffness_param,
                              external_points="0", mstate="@cosserat_base_mo", points="0", template="Rigid3d")
    return rigid_base_node


def _add_cosserat_state(p_node, bending_states, list_sections_length, _radius=beam_radius):
    cosserat_coordinate_node = p_node.addChild('cosseratCoordinate')
    cosserat_coordinate_node.addObject('MechanicalObject', template='Vec3d', name='cosserat_state', position=bending_states)
    cosserat_coordinate_node.addObject('BeamHookeLawForceField', crossSectionShape='circular', length=list_sections_length,
                                       radius=_radius, youngModulus=1.e4, poissonRatio=0.4)
    return cosserat_coordinate_node


def _add_cosserat_frame(p_node, _bending_node, framesF, _section_curv_abs, _frame_curv_abs, _beam_mass=0.1):
    cosserat_in_Sofa_frame_node = p_node.addChild('cosserat_in_Sofa_frame_node')
    _bending_node.addChild(cosserat_in_Sofa_frame_node)
    frames_mo = cosserat_in_Sofa_frame_node.addObject('MechanicalObject', template='Rigid3d', name="FramesMO", position=framesF,
                                                      showIndices=0., showObject=0, showObjectScale=0.8)
    cosserat_in_Sofa_frame_node.addObject('UniformMass', totalMass=_beam_mass)
    cosserat_in_Sofa_frame_node.addObject(
        'DiscreteCosseratMapping', curv_abs_input=_section_curv_abs, curv_abs_output=_frame_curv_abs, name='cosseratMapping',
        input1=_bending_node.cosserat_state.getLinkPath(), input2=p_node.cosserat_base_mo.getLinkPath(),
        output=frames_mo.getLinkPath(), debug=0, radius=beam_radius)
    return cosserat_in_Sofa_frame_node


def createScene(root_node):
    root_node.addObject('RequiredPlugin', name='Cosserat')
    root_node.addObject('VisualStyle', displayFlags='showBehaviorModels showMechanicalMappings')
    root_node.gravity = [0, -9.81, 0.]
    root_node.addObject('DefaultAnimationLoop')
    geometry = BeamGeometryParameters()
    solver = root_node.addChild("solver")
    solver.addObject('EulerImplicitSolver', firstOrder="0", rayleighStiffness="0.0", rayleighMass="0.0")
    solver.addObject('SparseLDLSolver', name='solver', template="CompressedRowSparseMatrixd")
    base_node = _add_rigid_base(solver)
    section = geometry.beam_length / geometry.nb_section
    lengths = [section] * geometry.nb_section
    curv_abs_sections = list(np.concatenate([[0.0], np.cumsum(lengths)]))
    frames_abs = np.linspace(0, geometry.beam_length, geometry.nb_frames + 1)
    frames = [[s, 0, 0, 0, 0, 0, 1] for s in frames_abs]
    bending_node = _add_cosserat_state(solver, [[0.0, 0.0, 0.0]] * geometry.nb_section, lengths)
    tip = _add_cosserat_frame(base_node, bending_node, frames, curv_abs_sections, list(frames_abs))
    tip.addObject('ConstantForceField', name='constForce', showArrowSize=1.e-2, indices=geometry.nb_frames, force=[0, -1e-2, 0, 0, 0, 0])
    return root_node
