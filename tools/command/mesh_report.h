// SPDX-License-Identifier: LGPL-2.1-or-later
// What `stroma mesh` says of a mesh.
#pragma once
#include <map>

#include "tools/command/mesh_request.h"
#include "tools/mesh/regions.h"

namespace stroma::command {

/// A connected part of a label in an image.
struct ImagePart {
  int label = 0;
  long voxels = 0;
  Vec3 place = Vec3::Zero();  ///< the centre of one of its voxels
  bool meshed = false;        ///< a cell of the label lies in it
};

struct Meshed {
  LabelledMesh mesh;
  std::map<int, double> wanted;  ///< volumes by label, those of the input
  std::vector<ImagePart> parts;  ///< of an image
  VolumeMatch match;             ///< of an image
  double voxel = 0;              ///< the smallest spacing of an image
  double expected_cells = 0;
  double read_seconds = 0, mesh_seconds = 0;
};

/// What a user should doubt, a line each on standard error.
void warnOfMesh(const MeshRequest& request, const Meshed& meshed, const MeshQuality& quality);
/// The report, as text or as JSON.
void printMeshReport(const MeshRequest& request, const Meshed& meshed, const MeshQuality& quality);

}  // namespace stroma::command
