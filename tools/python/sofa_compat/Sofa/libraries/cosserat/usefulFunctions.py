# SPDX-License-Identifier: LGPL-2.1-or-later
"""Sections and frames of a rod by the names that scenes give in a dict."""
pluginList = ["Cosserat"]


def buildEdges(cable3DPos):
    """Flat, from point to point."""
    return [number for i in range(len(cable3DPos) - 1) for number in (i, i + 1)]


def BuildCosseratGeometry(config):
    """Of init_pos, tot_length, nbSectionS and nbFramesF: bendings, where sections end, their lengths, frames, where these are, places."""
    x, y, z = config["init_pos"][:3]
    length, sections, frames = config["tot_length"], config["nbSectionS"], config["nbFramesF"]
    ends = [x + length * i / sections for i in range(sections)] + [x + length]
    along = [x + length * i / frames for i in range(frames)] + [x + length]
    return [[[0, 0, 0] for _ in range(sections)], ends, [length / sections] * sections, [[s, y, z, 0, 0, 0, 1] for s in along], along,
            [[s, y, z] for s in along]]
