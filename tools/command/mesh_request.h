// SPDX-License-Identifier: LGPL-2.1-or-later
// What `stroma mesh` is asked for.
#pragma once
#include <string>

#include "tools/command/session.h"
#include "tools/mesh/labelled_files.h"
#include "tools/mesh/mesh_generator.h"

namespace stroma::command {

struct MeshRequest {
  std::string input, output;
  double scale = 1;
  bool has_metres = false;  ///< positions of the mesh are in metres for certain
  double voxels = 0;  ///< of surfaces: the size of those to fill first; 0: none, the surface itself is kept
  MeshCriteria criteria;
  LabelNames names;
  double most_cells = 5e6;
  double progress = 5;  ///< seconds between two lines
  bool json = false, format_22 = false;
  int order = 1;  ///< of the cells: 2 puts a node on each edge
  bool toVtu() const { return output.ends_with(".vtu"); }
  /// The loader of the surface's format, or null: an image.
  const char* surfaceLoader() const;
};

CommandLine meshLine();

/// None when only the manual was wanted. Throws UsageError.
std::optional<MeshRequest> readMeshRequest(const Arguments& arguments);

/// Labels that the request names must be those of the input, and names must differ. Throws UsageError.
void checkLabels(const MeshRequest& request, const std::vector<int>& labels);

}  // namespace stroma::command
