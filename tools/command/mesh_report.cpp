// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/mesh_report.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace stroma::command {
namespace {

using Json = nlohmann::ordered_json;

constexpr double poor_angle = 8;      ///< [degrees]
constexpr double poor_volume = 0.01;  ///< relative

std::string tightness(const RegionReport& region) {
  if (!region.watertight()) return fmt::format("open at {} edges", region.open_edges);
  if (!region.manifold()) return fmt::format("closed, branching at {} edges", region.branching_edges);
  return "watertight";
}

/// Of the file, or of one label in it; `corners` are those of its cells.
Index countNodes(const MeshRequest& request, const Meshed& meshed, std::size_t corners, std::optional<int> label = {}) {
  return Index(corners) + (request.order == 2 ? countMiddles(meshed.mesh, label) : 0);
}

Json toJson(const MeshRequest& request, const Meshed& meshed, const MeshQuality& quality) {
  Json regions = Json::array();
  for (const RegionReport& region : quality.regions)
    regions.push_back({{"label", region.label},
                       {"name", nameOf(region.label, request.names)},
                       {"tetrahedra", region.tetrahedra},
                       {"nodes", countNodes(request, meshed, std::size_t(region.nodes), region.label)},
                       {"parts", region.parts},
                       {"volume", region.volume},
                       {"inputVolume", meshed.wanted.at(region.label)},
                       {"watertight", region.watertight()},
                       {"manifold", region.manifold()}});
  return {{"mesh", request.output},
          {"nodes", countNodes(request, meshed, meshed.mesh.position.size())},
          {"tetrahedra", meshed.mesh.tetrahedra.size()},
          {"smallestDihedralAngle", quality.smallest_angle},
          {"largestDihedralAngle", quality.largest_angle},
          {"worstTetrahedron", quality.worst},
          {"cellSize", request.criteria.cell_size},
          {"distance", request.criteria.distance},
          {"expectedTetrahedra", std::round(meshed.expected_cells)},
          {"readSeconds", meshed.read_seconds},
          {"meshSeconds", meshed.mesh_seconds},
          {"regions", regions}};
}

void print(const MeshRequest& request, const Meshed& meshed, const MeshQuality& quality) {
  Vec3 low = meshed.mesh.position.front(), high = low;
  for (const Vec3& p : meshed.mesh.position) low = low.cwiseMin(p), high = high.cwiseMax(p);
  fmt::print("{}: {} nodes, {} tetrahedra, read {:.2f} s, meshed {:.2f} s\n", request.output,
             countNodes(request, meshed, meshed.mesh.position.size()), meshed.mesh.tetrahedra.size(), meshed.read_seconds,
             meshed.mesh_seconds);
  const char* unit = request.has_metres ? " m" : "";
  fmt::print("box ({:.4g} {:.4g} {:.4g}) to ({:.4g} {:.4g} {:.4g}){}; cell size {:.4g}{}, distance {:.4g}{}\n", low.x(), low.y(), low.z(),
             high.x(), high.y(), high.z(), unit, request.criteria.cell_size, unit, request.criteria.distance, unit);
  const Tetrahedron& worst = meshed.mesh.tetrahedra[quality.worst];
  fmt::print("dihedral angles {:.2f} to {:.2f} degrees; the worst is tetrahedron {} (nodes {})\n",
             quality.smallest_angle, quality.largest_angle, quality.worst, fmt::join(worst, " "));
  for (const RegionReport& region : quality.regions) {
    const double wanted = meshed.wanted.at(region.label);
    fmt::print("label {} ({}): {} tetrahedra, {} nodes, {} part{}, volume {:.6g} ({:+.2f} % of the input's), {}\n",
               region.label, nameOf(region.label, request.names), region.tetrahedra,
               countNodes(request, meshed, std::size_t(region.nodes), region.label), region.parts,
               region.parts == 1 ? "" : "s", region.volume, 100 * (region.volume / wanted - 1), tightness(region));
  }
}

void warnOfVolume(const MeshRequest& request, const Meshed& meshed, const RegionReport& region) {
  const double error = region.volume / meshed.wanted.at(region.label) - 1;
  if (std::abs(error) <= poor_volume) return;
  const VolumeMatch& match = meshed.match;
  std::string why;
  if (match.at_reach > 0)
    why +=
        fmt::format("; {} nodes of boundaries have moved 0.3 of their shortest edge and go no further", match.at_reach);
  if (match.held_by_angles > 0)
    why += fmt::format("; {} went less far for the sake of dihedral angles", match.held_by_angles);
  const bool coarse = meshed.voxel == 0 || request.criteria.sizeOf(region.label) > 1.5 * meshed.voxel;
  fmt::print(stderr, "warning: the volume of label {} is {:+.1f} % off{}. {}\n", region.label, 100 * error, why,
             coarse ? "A smaller cell size or distance helps"
                    : "Cells as small as voxels follow the smoothed image: larger cells, or smaller voxels, help");
}

void warnOfParts(const Meshed& meshed, const MeshQuality& quality) {
  std::map<int, Index> meshed_parts;
  for (const ImagePart& part : meshed.parts) {
    meshed_parts[part.label] += part.meshed;
    if (part.meshed) continue;
    fmt::print(stderr,
               "warning: a part of label {} is not in the mesh: {} voxel{} about {:.6g} {:.6g} {:.6g}, too thin or too "
               "small for the cells; its volume went to the rest of the label\n",
               part.label, part.voxels, part.voxels == 1 ? "" : "s", part.place.x(), part.place.y(), part.place.z());
  }
  for (const RegionReport& region : quality.regions)
    if (const auto found = meshed_parts.find(region.label); found != meshed_parts.end() && region.parts > found->second)
      fmt::print(stderr, "warning: label {} has {} parts in the mesh where the image has {}: thin places came apart\n",
                 region.label, region.parts, found->second);
}

}  // namespace

void warnOfMesh(const MeshRequest& request, const Meshed& meshed, const MeshQuality& quality) {
  if (quality.smallest_angle < poor_angle)
    fmt::print(stderr,
               "warning: the smallest dihedral angle is {:.2f} degrees: another cell size or distance may do better\n",
               quality.smallest_angle);
  warnOfParts(meshed, quality);
  for (const RegionReport& region : quality.regions) {
    const Vec3& at = region.place;
    if (!region.watertight())
      fmt::print(stderr, "warning: the surface of label {} is open at {} edges, the first near {:.6g} {:.6g} {:.6g}\n",
                 region.label, region.open_edges, at.x(), at.y(), at.z());
    else if (!region.manifold())
      fmt::print(
          stderr,
          "warning: the surface of label {} is closed but branches: more than two triangles meet at {} edges, the "
          "first near {:.6g} {:.6g} {:.6g}; parts that touch there hang together by an edge\n",
          region.label, region.branching_edges, at.x(), at.y(), at.z());
    warnOfVolume(request, meshed, region);
  }
}

void printMeshReport(const MeshRequest& request, const Meshed& meshed, const MeshQuality& quality) {
  if (request.json)
    fmt::print("{}\n", toJson(request, meshed, quality).dump(2, ' ', false, Json::error_handler_t::replace));
  else
    print(request, meshed, quality);
}

}  // namespace stroma::command
