// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/surface_load.h"

#include <fmt/format.h>

#include <map>

namespace stroma {

namespace {

Mat3 crossMatrix(const Vec3& w) {
  Mat3 m;
  m << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  return m;
}

/// The nodes of an edge that the faces do not run through as often one way as the other, or empty.
std::string firstOpenEdge(const std::vector<Face>& faces) {
  std::map<Edge, int> turns;
  for (const Face& face : faces)
    for (int i = 0; i < face.corners; ++i) {
      const Index a = face.nodes[std::size_t(i)], b = face.nodes[std::size_t((i + 1) % face.corners)];
      turns[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  for (const auto& [edge, sum] : turns)
    if (sum != 0) return fmt::format("{} {}", edge[0], edge[1]);
  return {};
}

}  // namespace

void SurfaceLoad::declare(DataTable& table) {
  ForceField::declare(table);
  table.addLink("topology", topology_).help("surface; the mesh of this node or the nearest above when not given");
  table.addChoice("tangent", tangent_, {"symmetric", "exact"})
      .help(
          "symmetric part of the stiffness, which any solver takes and which is exact for a pressure on a closed "
          "surface or one with a held rim; or the exact one, on an open surface for solvers of unsymmetric matrices");
}

const Mesh& SurfaceLoad::surfaceMesh() const {
  const Topology* topology = topology_.get() ? topology_.get() : find<Topology>(true);
  if (!topology) throw ComponentError("no mesh in this node or above", "a topology with triangles or quads");
  if (topology->mesh().nodes() != state().size())
    throw ComponentError(fmt::format("{} has {} nodes and {} has {}", topology->path(), topology->mesh().nodes(),
                                     state().path(), state().size()),
                         "a mesh and a state of the same nodes");
  return topology->mesh();
}

void SurfaceLoad::setFaces(std::vector<Face> faces, std::vector<double> weights) {
  faces_ = std::move(faces);
  weights_ = std::move(weights);
  open_edge_ = firstOpenEdge(faces_);
}

ForceTraits SurfaceLoad::traits() const {
  ForceTraits traits;
  const bool potential = hasPotential(), exact = tangent_ == TangentWord::exact && !potential;
  traits.conservative = potential;
  traits.has_stiffness = has_tangent;
  traits.symmetric = !exact || !has_tangent;
  traits.exact_tangent = has_tangent && stress_is_fixed && (exact || potential);
  return traits;
}

void SurfaceLoad::compile() {
  std::vector<Group> rows;
  for (const Face& face : faces_) {
    rows.push_back(face.nodes);
    for (Index& row : rows.back()) row += state().firstRow();
  }
  setGroups(std::move(rows), false);
  for (std::size_t i = 0; i < faces_.size(); ++i) stiffness_[i].corners = faces_[i].corners;
}

void SurfaceLoad::addLoadedRows(std::vector<Index>& rows) const {
  for (const Face& face : faces_)
    for (int a = 0; a < face.corners; ++a) rows.push_back(state().firstRow() + face.nodes[std::size_t(a)]);
}

void SurfaceLoad::addForce(ConstRows x, ConstRows, Rows f) {
  using namespace area_vectors;
  const Mat3 s = stress(x);
  const bool exact = tangent_ == TangentWord::exact && !hasPotential();
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    const int corners = faces_[i].corners;
    const Mat3 weighted = (weights_.empty() ? 1. : weights_[i]) * s;
    Corners at;
    for (std::size_t a = 0; a < 4; ++a) at[a] = x[rows_[i][a]];
    const Corners areas = of(at, corners);
    for (int a = 0; a < corners; ++a) f[rows_[i][std::size_t(a)]] += weighted * areas[std::size_t(a)];
    if (!has_tangent) continue;
    const Gradients w = gradients(at, corners);
    for (int a = 0; a < corners; ++a)
      for (int b = 0; b < corners; ++b) {
        const Mat3 k = weighted * crossMatrix(w[std::size_t(4 * a + b)]);
        // [w]x^T = -[w]x
        stiffness_[i].block(a, b) = exact ? k : Mat3(k - crossMatrix(w[std::size_t(4 * b + a)]) * weighted) / 2;
      }
  }
}

template <class Position>
double SurfaceLoad::volumeAt(Position&& position) const {
  // from a node of the surface: far from the origin the terms would cancel
  const Vec3 origin = position(faces_[0].nodes[0]);
  double sum = 0;
  for (const Face& face : faces_) {
    area_vectors::Corners at;
    for (std::size_t a = 0; a < 4; ++a) at[a] = position(face.nodes[a]) - origin;
    const area_vectors::Corners areas = area_vectors::of(at, face.corners);
    for (int a = 0; a < face.corners; ++a) sum += at[std::size_t(a)].dot(areas[std::size_t(a)]) / 3;
  }
  return sum;
}

double SurfaceLoad::volume(ConstRows x) const {
  return volumeAt([&](Index node) -> Vec3 { return x[state().firstRow() + node]; });
}

double SurfaceLoad::restVolume() const {
  return volumeAt([&](Index node) -> Vec3 { return state().rest_position[std::size_t(node)]; });
}

}  // namespace stroma
