// SPDX-License-Identifier: LGPL-2.1-or-later
// The service `meshing`: meshes of images and of closed surfaces by CGAL's Mesh_3.
#include "framework/scene/abi.h"
#include "framework/scene/modules.h"
#include "framework/scene/services.h"
#include "tools/mesh/meshing/mesher.h"

namespace stroma {
namespace {

class CgalMeshGenerator final : public MeshGenerator {
 public:
  LabelledMesh fromImage(const LabelImage& image, const MeshCriteria& criteria, VolumeMatch& match) const override {
    LabelledMesh mesh = meshing::meshImage(image, criteria);
    if (!criteria.keep_volume) return mesh;
    std::map<int, double> wanted;
    const std::vector<long> voxels = image.voxels();
    for (std::size_t i = 0; i < voxels.size(); ++i) wanted[image.values[i]] = double(voxels[i]) * image.voxelVolume();
    match = matchVolumes(mesh, wanted, meshing::least_share * criteria.dihedral_angle);
    return mesh;
  }
  LabelledMesh fromSurface(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles,
                           const MeshCriteria& criteria) const override {
    return meshing::meshSurface(position, triangles, criteria);
  }
};

}  // namespace
}  // namespace stroma

extern "C" __attribute__((visibility("default"))) const stroma::ServiceInfo* stroma_service() {
  static const stroma::ServiceInfo info{STROMA_ABI, stroma::MeshGenerator::role, []() -> void* {
                                          return static_cast<stroma::MeshGenerator*>(new stroma::CgalMeshGenerator);
                                        }};
  return &info;
}
