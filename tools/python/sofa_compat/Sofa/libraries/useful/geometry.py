# SPDX-License-Identifier: LGPL-2.1-or-later
"""Sections and frames along a rod that is straight along x."""


def _along(length, parts):
    return [length * i / parts for i in range(parts)] + [length]


def calculate_beam_parameters(parameters):
    """(bendings of the sections, where they end, their lengths)."""
    count, length = int(parameters.nb_section), float(parameters.beam_length)
    if count <= 0 or not length > 0:
        raise ValueError(f"a rod has a length and sections, and not {length} and {count}")
    return [[0.0, 0.0, 0.0] for _ in range(count)], _along(length, count), [length / count] * count


def calculate_frame_parameters(parameters):
    """(frames, where along the rod they are, their places)."""
    count, length = int(parameters.nb_frames), float(parameters.beam_length)
    if count <= 0 or not length > 0:
        raise ValueError(f"a rod has a length and frames, and not {length} and {count}")
    places = _along(length, count)
    return [[s, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0] for s in places], places, [[s, 0.0, 0.0] for s in places]


def generate_edge_list(places):
    return [[i, i + 1] for i in range(len(places) - 1)]


class CosseratGeometry:
    """Both, under the names of then and of now."""

    def __init__(self, parameters):
        self.bendingState, self.curv_abs_inputS, self.sectionsLengthList = calculate_beam_parameters(parameters)
        self.framesF, self.curv_abs_outputF, self.cable_positionF = calculate_frame_parameters(parameters)
        self.bending_states, self.curv_abs_sections, self.section_lengths = self.bendingState, self.curv_abs_inputS, self.sectionsLengthList
        self.section_curvilinear_abscissae, self.frames, self.curv_abs_frames = self.curv_abs_inputS, self.framesF, self.curv_abs_outputF
        self.cable_positions = self.cable_positionF
