// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/mechanics/mesh_mass.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "framework/mechanics/state_positions.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_lists.h"
#include "framework/mesh/simplex_size.h"

namespace stroma {

// ---- integrals ----

namespace {

/// V (1 + delta_ij) / ((d + 1)(d + 2)), count = d + 1.
void simplexMatrix(int count, double size, CellMatrix& out) {
  const double entry = size / (count * (count + 1));
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < count; ++j) out[std::size_t(i * count + j)] = i == j ? 2 * entry : entry;
}

/// A point of a rule, with what does not depend on the cell.
struct TabledPoint {
  double weight = 0;
  std::array<double, most_cell_nodes> shape{};
  std::array<LocalPoint, most_cell_nodes> slopes{};
};

/// Made once per kind: shapes and slopes cost more than the rest of the integral.
const std::vector<TabledPoint>& pointsOf(const CellKind& kind) {
  thread_local std::map<const CellKind*, std::vector<TabledPoint>> tables;
  std::vector<TabledPoint>& table = tables[&kind];
  if (!table.empty()) return table;
  for (const QuadraturePoint& point : kind.rule(2 * kind.order).points) {
    TabledPoint& tabled = table.emplace_back();
    tabled.weight = point.weight;
    kind.shapes(point.xi, tabled.shape.data());
    kind.gradients(point.xi, tabled.slopes.data());
  }
  return table;
}

/// det dx/dxi of a volume, or the area over that of the reference cell.
double measureAt(const CellKind& kind, const std::array<LocalPoint, most_cell_nodes>& slopes, const Vec3* x) {
  Mat3 jacobian = Mat3::Zero();
  for (int a = 0; a < kind.nodes; ++a) jacobian += x[a] * Vec3(slopes[a][0], slopes[a][1], slopes[a][2]).transpose();
  return kind.dimension == 3 ? jacobian.determinant() : jacobian.col(0).cross(jacobian.col(1)).norm();
}

}  // namespace

void cellMassMatrix(const MassCell& cell, const std::vector<Vec3>& position, CellMatrix& out) {
  const CellKind& kind = *cell.kind;
  std::array<Vec3, most_cell_nodes> x;
  for (int a = 0; a < kind.nodes; ++a) x[a] = position[cell.nodes[a]];
  if (kind.affine) return simplexMatrix(kind.nodes, simplexSize(kind.dimension, x.data()), out);
  out.fill(0);
  for (const TabledPoint& point : pointsOf(kind)) {
    const double measure = point.weight * measureAt(kind, point.slopes, x.data());
    for (int i = 0; i < kind.nodes; ++i)
      for (int j = 0; j < kind.nodes; ++j) out[std::size_t(i * kind.nodes + j)] += measure * point.shape[i] * point.shape[j];
  }
}

// ---- attributes ----

void MeshMass::declare(DataTable& table) {
  Mass::declare(table);
  table.add("massDensity", mass_density_)
      .help(
          "density, one for all cells or one per cell (tetrahedra, hexahedra, prisms, pyramids); per area on meshes without "
          "volumes, that of a sheet times its thickness, and per length on lines")
      .unit("kg/m^3 or kg/m^2 or kg/m")
      .ofCells()
      .min(0, false);
  table.add("totalMass", total_mass_)
      .help("mass of the body; wins over massDensity and vertexMass")
      .unit("kg")
      .min(0, false);
  table.add("vertexMass", vertex_mass_).help("mass of each node, one for all or one per node").unit("kg").min(0, false);
  table.add("lastForOthers", last_for_others_).help("nodes beyond the end of vertexMass have its last value, as in SOFA");
  table.add("computeMassOnRest", compute_on_rest_)
      .help("take volumes from the rest positions, not from the initial ones");
  table.addChoice("cells", which_cells_, {"all", "first"})
      .help("which carry mass: all of the highest dimension, or the first kind of hexahedra, tetrahedra, quads, triangles, edges");
  table.addChoice("shares", shares_, {"integrals", "equal"})
      .help("of a cell's mass at its nodes: the integrals, or for DiagonalMass the same at all, where quads are two triangles");
  table.add("absoluteVolumes", absolute_volumes_).help("inverted cells have the mass of their volume without its sign, as in SOFA");
  topology_.declare(table, "mesh of the cells");
  table.addLink("geometryState", geometry_state_)
      .help("state whose positions give the volumes; the mass's own by default");
}

MeshMass::Source MeshMass::chooseSource() {
  std::vector<std::string> given;
  for (const char* name : {"totalMass", "massDensity", "vertexMass"})
    if (data().find(name)->isSet()) given.push_back(name);
  if (given.empty()) {
    warn("no massDensity, totalMass or vertexMass: the total mass is set to 1 kg", "give massDensity [kg/m^3]");
    return Source::total;
  }
  for (std::size_t i = 1; i < given.size(); ++i)
    warn(fmt::format("both {} and {} are given: {} is used", given[0], given[i], given[0]), "remove " + given[i]);
  return given[0] == "totalMass" ? Source::total : given[0] == "massDensity" ? Source::density : Source::nodes;
}

void MeshMass::init() {
  Mass::init();
  source_ = chooseSource();
  if (source_ == Source::nodes) {
    const std::size_t nodes = std::size_t(state().nodes());
    const bool is_short = !vertex_mass_.empty() && vertex_mass_.size() < nodes;
    if (is_short && (vertex_mass_.size() == 1 || last_for_others_)) vertex_mass_.resize(nodes, vertex_mass_.back());
    if (vertex_mass_.size() != nodes)
      throw ComponentError(
          fmt::format("vertexMass has {} values for the {} nodes of {}", vertex_mass_.size(), nodes, state().path()),
          fmt::format("1 value or {}", nodes));
    return;
  }
  collectCells(mesh());
  findDensities(mesh().overlap);
}

void MeshMass::findMesh() {
  mesh_owner_ = topology_.find(*this, state());
  if (!mesh_owner_)
    throw ComponentError("there is no mesh whose cells could carry the mass",
                         "a topology in this node or above, or topology=\"@path\"", "UniformMass needs no mesh");
  const State& positions = geometry_state_.get() ? *geometry_state_.get() : state();
  geometry_ = compute_on_rest_ ? &positions.rest_position : &positions.position;
  if (positions.hasFrames()) geometry_ = &(places_ = nodePlaces(positions, *geometry_));
  if (Index(geometry_->size()) != state().nodes())
    throw ComponentError(fmt::format("{} has {} nodes and {} has {}", positions.path(), geometry_->size(),
                                     state().path(), state().nodes()),
                         "a geometryState of as many nodes as the state");
}

void MeshMass::collectCells(const Mesh& mesh) {
  const int highest = highestDimension(mesh);
  const CellKind* hidden = nullptr;  // by cells of as many dimensions that have a body of their own already
  if (which_cells_ == Cells::first && !mesh.hexahedra.empty()) hidden = &cell_kinds::tetrahedron;
  if (which_cells_ == Cells::first && highest == 2 && !mesh.quads.empty()) hidden = &cell_kinds::triangle;
  forEachCellList(
      [&](const CellKind& kind, const auto& list) {
        if (kind.dimension == highest && &kind != hidden)
          for (const auto& cell : list) cells_.push_back({&kind, cell.data()});
      },
      mesh);
  if (cells_.empty())
    throw ComponentError("the mesh " + mesh_owner_->path() + " has no cells that could carry the mass",
                         "tetrahedra, hexahedra, triangles, quads or edges", "UniformMass needs no cells");
}

std::string MeshMass::cellName(std::size_t cell) const {
  std::size_t first = cell;
  while (first > 0 && cells_[first - 1].kind == cells_[cell].kind) --first;
  std::string text = fmt::format("{} {} (nodes", cells_[cell].kind->singular, cell - first);
  for (int i = 0; i < cells_[cell].kind->nodes; ++i) text += fmt::format(" {}", cells_[cell].nodes[i]);
  return text + ")";
}

void MeshMass::findDensities(double overlap) {
  double volume = 0, mass = 0;
  const bool given = source_ == Source::density;
  if (given && mass_density_.size() != 1 && mass_density_.size() != cells_.size())
    throw ComponentError(fmt::format("massDensity has {} values for the {} cells of {}", mass_density_.size(),
                                     cells_.size(), mesh_owner_->path()),
                         fmt::format("1 value or {}", cells_.size()));
  CellMatrix matrix;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    massMatrixOf(i, matrix);
    double size = 0;
    for (int k = 0; k < cells_[i].kind->nodes * cells_[i].kind->nodes; ++k) size += matrix[k];
    if (!(size >= 0))
      throw ComponentError(fmt::format("{} of {} has a volume of {:.3g}, so its mass would be negative", cellName(i),
                                       mesh_owner_->path(), size),
                           "cells that are not inverted",
                           compute_on_rest_ ? "" : "computeMassOnRest=\"true\" when only the start is deformed");
    volume += size / overlap;
    if (given) mass += size / overlap * mass_density_[mass_density_.size() == 1 ? 0 : i];
  }
  if (!(volume > 0))
    throw ComponentError("all cells of " + mesh_owner_->path() + " are flat, so they have no mass",
                         "cells with a volume");
  densities_ = given ? mass_density_ : std::vector<double>{total_mass_ / volume};
  for (double& density : densities_) density /= overlap;
  if (given) {
    total_mass_ = mass;
  } else {
    mass_density_ = {total_mass_ / volume};
  }
}

void MeshMass::massMatrixOf(std::size_t cell, CellMatrix& out) const {
  cellMassMatrix(cells_[cell], *geometry_, out);
  const auto [kind, nodes] = cells_[cell];
  const std::size_t entries = std::size_t(kind->nodes) * std::size_t(kind->nodes);
  if (absolute_volumes_ && std::accumulate(out.begin(), out.begin() + std::ptrdiff_t(entries), 0.) < 0)
    for (std::size_t k = 0; k < entries; ++k) out[k] = -out[k];
  if (shares_ != Shares::equal || kind != &cell_kinds::quad) return;
  const auto at = [&](int corner) -> const Vec3& { return (*geometry_)[std::size_t(nodes[corner])]; };
  const Vec3 across = at(2) - at(0);
  const double area = ((at(1) - at(0)).cross(across).norm() + across.cross(at(3) - at(0)).norm()) / 2;
  double sum = 0;
  for (std::size_t k = 0; k < 16; ++k) sum += out[k];
  for (std::size_t k = 0; k < 16 && sum > 0; ++k) out[k] *= area / sum;
}

void MeshMass::addLumped(std::vector<double>& masses) const {
  CellMatrix matrix;
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    const auto [kind, nodes] = cells_[c];
    const std::size_t count = std::size_t(kind->nodes);
    massMatrixOf(c, matrix);
    double sum = 0, diagonal = 0;
    for (std::size_t k = 0; k < count * count; ++k) sum += matrix[k];
    for (std::size_t i = 0; i < count; ++i) diagonal += matrix[i * count + i];
    for (std::size_t i = 0; i < count; ++i) {
      if (kind->order > 1) {
        masses[nodes[i]] += density(c) * (diagonal > 0 ? sum / diagonal * matrix[i * count + i] : 0);
        continue;
      }
      if (shares_ == Shares::equal) {
        masses[nodes[i]] += density(c) * sum / double(count);
        continue;
      }
      for (std::size_t j = 0; j < count; ++j) masses[nodes[i]] += density(c) * matrix[i * count + j];
    }
  }
}

void MeshMass::checkMasses(const std::vector<double>& masses) const {
  std::vector<char> used(masses.size(), isNodal());
  for (const MassCell& cell : cells_)
    for (int i = 0; i < cell.kind->nodes; ++i) used[cell.nodes[i]] = 1;
  const auto unused = std::count(used.begin(), used.end(), 0);
  if (unused > 0) {
    const auto first = std::find(used.begin(), used.end(), 0) - used.begin();
    warn(fmt::format("{} of {} nodes belong to no cell of {} and get no mass, the first is node {}", unused,
                     used.size(), mesh_owner_->path(), first),
         "remove them from the mesh, or fix them");
  }
  for (std::size_t i = 0; i < masses.size(); ++i)
    if (used[i] && !(masses[i] > 0))
      throw ComponentError(fmt::format("node {} of {} gets a mass of {:.3g} kg", i, state().path(), masses[i]),
                           "a positive mass at every node", "look for flat cells around this node");
}

void MeshMass::finish(std::vector<double> nodal) {
  vertex_mass_ = std::move(nodal);
  if (isNodal()) total_mass_ = std::accumulate(vertex_mass_.begin(), vertex_mass_.end(), 0.0);
  cells_ = {};
  densities_ = {};
}

}  // namespace stroma
