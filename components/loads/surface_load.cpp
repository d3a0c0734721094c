// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/loads/surface_load.h"
#include "framework/mechanics/state_topology.h"

#include <fmt/format.h>

namespace stroma {

namespace {

Mat3 crossMatrix(const Vec3& w) {
  Mat3 m;
  m << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  return m;
}

}  // namespace

void SurfaceLoad::declare(DataTable& table) {
  ForceField::declare(table);
  topology_.declare(table, "surface");
  table.addChoice("tangent", tangent_, {"symmetric", "exact"})
      .help(
          "symmetric part of the stiffness, which any solver takes and which is exact for a pressure on a closed "
          "surface or one with a held rim; or the exact one, on an open surface for solvers of unsymmetric matrices. Where none is "
          "written, a solve of Newton's method that fails goes on with the exact one, if its linear solver takes it");
}

const Mesh& SurfaceLoad::surfaceMesh() const {
  const Topology* topology = topology_.find(*this, state());
  if (!topology) throw ComponentError("no mesh in this node or above", "a topology with triangles or quads");
  return topology->mesh();
}

void SurfaceLoad::setFaces(std::vector<Face> faces, std::vector<double> weights) {
  faces_ = std::move(faces);
  weights_ = std::move(weights);
  const auto open = firstOpenEdge(faces_);
  open_edge_ = open ? fmt::format("{} {}", open->nodes[0], open->nodes[1]) : "";
}

ForceTraits SurfaceLoad::traits() const {
  ForceTraits traits;
  const bool potential = hasPotential(), exact = isExact();
  traits.conservative = potential;
  traits.has_stiffness = has_tangent;
  traits.symmetric = !exact || !has_tangent;
  traits.exact_tangent = has_tangent && rigid_faces == 0 && stress_is_fixed && (exact || potential);
  return traits;
}

bool SurfaceLoad::useExactTangent(bool exact) {
  // a tangent that the scene names stays
  if (hasPotential() || !has_tangent || data().find("tangent")->isSet()) return false;
  is_exact_for_solve_ = exact;
  return true;
}

void SurfaceLoad::compile() {
  std::vector<Group> rows;
  for (const Face& face : faces_) {
    rows.push_back(face.nodes);
    for (Index& row : rows.back()) row += state().firstRow();
  }
  setGroups(std::move(rows), false);
  for (std::size_t i = 0; i < faces_.size(); ++i) stiffness_[i].corners = faces_[i].corners;
  if (has_tangent) corners_.resize(faces_.size());
}

void SurfaceLoad::addLoadedRows(std::vector<Index>& rows) const {
  for (const Face& face : faces_)
    for (int a = 0; a < face.corners; ++a) rows.push_back(state().firstRow() + face.nodes[a]);
}

void SurfaceLoad::addForce(ConstRows x, ConstRows, Rows f) {
  const Mat3 s = stress(x);
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    const int corners = faces_[i].corners;
    area_vectors::Corners at;
    for (std::size_t a = 0; a < at.size(); ++a) at[a] = x[rows_[i][a]];
    const area_vectors::Corners areas = area_vectors::of(at, corners);
    const Mat3 weighted = weight(i) * s;
    for (int a = 0; a < corners; ++a) f[rows_[i][a]] += weighted * areas[a];
    if (has_tangent) corners_[i] = at;
  }
  last_stress_ = s;
  if (has_tangent) outdateTangents();
}

void SurfaceLoad::computeTangents() const {
  const bool exact = isExact();
  for (std::size_t i = 0; i < faces_.size() - rigid_faces; ++i) {
    const int corners = faces_[i].corners;
    const Mat3 weighted = weight(i) * last_stress_;
    const area_vectors::Gradients w = area_vectors::gradients(corners_[i], corners);
    for (int a = 0; a < corners; ++a)
      for (int b = 0; b < corners; ++b) {
        const Mat3 k = weighted * crossMatrix(w[std::size_t(face_nodes * a + b)]);
        // [w]x^T = -[w]x
        stiffness_[i].block(a, b) =
            exact ? k : Mat3(k - crossMatrix(w[std::size_t(face_nodes * b + a)]) * weighted) / 2;
      }
  }
}

double SurfaceLoad::volume(ConstRows x) const {
  return area_vectors::volumeBehind(faces_, [&](Index node) -> Vec3 { return x[state().firstRow() + node]; });
}

double SurfaceLoad::restVolume() const {
  return area_vectors::volumeBehind(faces_, [&](Index node) -> Vec3 { return state().rest_position[node]; });
}

}  // namespace stroma
