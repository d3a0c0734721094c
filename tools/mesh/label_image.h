// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/scene/types.h"

namespace stroma {

/// A segmented volume image: one label a voxel, 0 outside of the body.
struct LabelImage {
  std::array<Index, 3> size{0, 0, 0};  ///< voxels along the three axes of the image
  Vec3 origin = Vec3::Zero();          ///< centre of the first voxel, in the image's unit of length
  Mat3 steps = Mat3::Identity();       ///< column k: from one voxel to the next along axis k (any direction)
  std::vector<int> values;             ///< the labels that occur, without 0, ascending
  std::vector<std::uint8_t> region;    ///< of each voxel, first axis fastest: 0 outside, i + 1 for values[i]

  double voxelVolume() const;
  std::vector<long> voxels() const;  ///< how many voxels each of `values` has
  double smallestSpacing() const;
  Vec3 bodySize() const;  ///< of the box around all voxels but those outside, along the image's axes
};

/// The parts of an array of regions that are connected through faces of voxels.
struct ConnectedParts {
  std::vector<Index> part;         ///< of each voxel, -1 outside
  std::vector<long> voxels;        ///< of each part
  std::vector<std::size_t> first;  ///< voxel of each part
};
/// `region` as in LabelImage, first axis fastest.
ConnectedParts connectedParts(const std::array<Index, 3>& size, const std::vector<std::uint8_t>& region);

/// Reads a segmented image: NIfTI, MetaImage or VTK's image data. Throws ComponentError with a sentence when the file
/// cannot be read or is not a segmentation: more than 255 labels, negative or fractional values, several components, no
/// voxel but 0. (In a process of its own, with VTK.)
LabelImage readLabelImage(const std::string& file);

}  // namespace stroma
