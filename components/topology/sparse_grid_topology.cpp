// SPDX-License-Identifier: LGPL-2.1-or-later
// SparseGridTopology: the cells of a box that lie in a closed surface, or that the surface goes through.
//
// The box (min, max; that of the surface grown by 1 % on each side when both are zero) has n nodes along its axes, or cells of
// the size cellWidth. A cell that a triangle of the surface meets is a BORDER cell; one that is reached from outside of the
// box without crossing border cells lies OUTSIDE; all others lie INSIDE. Hexahedra: border cells in the order of the grid, then
// inside cells (those alone with onlyInsideCells). Nodes: the corners in use, ascending in x, then y, then z.
//
// cellFactors is how much of a cell the body fills, 1 inside and 0.5 on the border; with fillWeighted="false" 1. As
// localStiffnessFactor="@grid.cellFactors" of a force field it makes the border softer. With nbVirtualFinerLevels k the surface
// is looked at on a grid that is 2^k times as fine: a cell lies inside when all of its fine cells do, is on the border when some
// do or are cut, and its factor is the mean of theirs.
//
// Source: M. Nesme, Y. Payan, F. Faure: Animating shapes at arbitrary resolution with non-uniform stiffness (2006); names,
// attributes and the order of cells and nodes are SOFA's. Boxes and triangles: T. Akenine-Moller 2001.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-9"/>
//   <SparseGridTopology name="grid" n="5 5 5" position="0 0 0  1 0 0  0 1 0  0 0 1" triangles="0 2 1  0 1 3  1 2 3  2 0 3"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="1"/>
//   <HexahedronFEMForceField youngModulus="1e4" poissonRatio="0.3" localStiffnessFactor="@grid.cellFactors"/>
//   <FixedProjectiveConstraint indices="0 1"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "framework/mesh/cell_attributes.h"
#include "framework/mesh/topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

enum class Place : char { unknown, border, outside };  ///< unknown in the end: inside

/// Whether a triangle with corners t meets the box of half sizes h around the origin: no axis separates them.
bool meetsBox(const std::array<Vec3, 3>& t, const Vec3& h) {
  const auto separates = [&](const Vec3& axis) {
    const double a = axis.dot(t[0]), b = axis.dot(t[1]), c = axis.dot(t[2]), r = h.dot(axis.cwiseAbs());
    return std::min({a, b, c}) > r || std::max({a, b, c}) < -r;
  };
  for (int i = 0; i < 3; ++i)
    if (separates(Vec3::Unit(i))) return false;
  if (separates((t[1] - t[0]).cross(t[2] - t[0]))) return false;
  for (std::size_t e = 0; e < 3; ++e)
    for (int i = 0; i < 3; ++i)
      if (separates((t[(e + 1) % 3] - t[e]).cross(Vec3::Unit(i)))) return false;
  return true;
}

/// Cells of a box, x fastest.
class Cells {
 public:
  Cells(const std::array<int, 3>& count, const Vec3& low, const Vec3& high)
      : count_(count),
        low_(low),
        size_((high - low).cwiseQuotient(Vec3(count[0], count[1], count[2]))),
        places_(std::size_t(count[0]) * std::size_t(count[1]) * std::size_t(count[2]), Place::unknown) {}
  Place& at(int i, int j, int k) { return places_[index(i, j, k)]; }

  void markBorder(const std::array<Vec3, 3>& corners) {
    std::array<int, 3> first{}, last{};
    for (int a = 0; a < 3; ++a) {
      const double least = std::min({corners[0][a], corners[1][a], corners[2][a]});
      const double most = std::max({corners[0][a], corners[1][a], corners[2][a]});
      const double end = count_[std::size_t(a)] - 1;
      first[std::size_t(a)] = int(std::clamp(std::floor((least - low_[a]) / size_[a]), 0., end));
      last[std::size_t(a)] = int(std::clamp(std::floor((most - low_[a]) / size_[a]), 0., end));
    }
    for (int k = first[2]; k <= last[2]; ++k)
      for (int j = first[1]; j <= last[1]; ++j)
        for (int i = first[0]; i <= last[0]; ++i) {
          const Vec3 middle = low_ + size_.cwiseProduct(Vec3(i + 0.5, j + 0.5, k + 0.5));
          if (meetsBox({corners[0] - middle, corners[1] - middle, corners[2] - middle}, size_ / 2))
            at(i, j, k) = Place::border;
        }
  }
  /// Spreads from the sides of the box.
  void markOutside() {
    std::vector<std::array<int, 3>> waiting;
    const auto enter = [&](int i, int j, int k) {
      if (i < 0 || j < 0 || k < 0 || i >= count_[0] || j >= count_[1] || k >= count_[2]) return;
      if (at(i, j, k) != Place::unknown) return;
      at(i, j, k) = Place::outside;
      waiting.push_back({i, j, k});
    };
    for (int k = 0; k < count_[2]; ++k)
      for (int j = 0; j < count_[1]; ++j)
        for (int i = 0; i < count_[0]; ++i)
          if (i == 0 || j == 0 || k == 0 || i == count_[0] - 1 || j == count_[1] - 1 || k == count_[2] - 1) enter(i, j, k);
    while (!waiting.empty()) {
      const auto [i, j, k] = waiting.back();
      waiting.pop_back();
      enter(i - 1, j, k), enter(i + 1, j, k), enter(i, j - 1, k), enter(i, j + 1, k), enter(i, j, k - 1), enter(i, j, k + 1);
    }
  }

 private:
  std::size_t index(int i, int j, int k) const {
    return std::size_t(i) + std::size_t(count_[0]) * (std::size_t(j) + std::size_t(count_[1]) * std::size_t(k));
  }
  std::array<int, 3> count_;
  Vec3 low_, size_;
  std::vector<Place> places_;
};

class SparseGridTopology final : public Topology {
 public:
  void declare(DataTable& table) override {
    table.add("n", n_).help("number of nodes in x, y, z").unit("-").min(2);
    for (std::size_t a = 0; a < 3; ++a)
      table.add(std::string("n") + "xyz"[a], counts_[a]).help("number of nodes along one axis").min(2).shorthand();
    table.add("min", min_).help("lower corner of the box; both zero: the box of the surface, and 1 % more").unit("m");
    table.add("max", max_).help("upper corner of the box").unit("m");
    table.add("cellWidth", width_).help("when positive, gives n from the box").unit("m").min(0);
    table.add("position", mesh_.position).alias("points").help("nodes of the surface; then of the grid").unit("m");
    addCellList(table, cell_kinds::triangle, triangles_).help("of the surface");
    addCellList(table, cell_kinds::quad, quads_).help("of the surface");
    table.add("nbVirtualFinerLevels", finer_).help("how often the surface is looked at with cells of half the size").min(0).max(6);
    table.add("onlyInsideCells", only_inside_).help("no cells on the border");
    table.add("fillWeighted", weighted_).help("cells on the border have a factor below 1");
    addCellList(table, cell_kinds::hexahedron, mesh_.hexahedra).help("the cells").output();
    table.add("cellFactors", factors_).help("how much of each cell is filled").unit("-").output();
    for (const char* name : {"facets", "computeHexaList", "convolutionSize", "marchingCubeStep", "dataResolution", "voxelSize"})
      table.addVisualOnly(name);
  }

  void init() override {
    const std::vector<Vec3> surface = mesh_.position;
    for (const Quad& q : quads_) triangles_.push_back({q[0], q[1], q[2]}), triangles_.push_back({q[0], q[2], q[3]});
    if (surface.empty() || triangles_.empty())
      throw ComponentError("there is no surface to fill", "position and triangles, as by src=\"@loader\"");
    for (const Triangle& t : triangles_)
      for (const Index node : t)
        if (node < 0 || std::size_t(node) >= surface.size())
          throw ComponentError(fmt::format("a triangle names node {} of {}", node, surface.size()));
    findBox(surface);
    fill(surface);
    tellVolume(surface);
  }

 private:
  void findBox(const std::vector<Vec3>& surface) {
    if (min_.isZero(0) && max_.isZero(0)) {
      min_ = max_ = surface.front();
      for (const Vec3& p : surface) min_ = min_.cwiseMin(p), max_ = max_.cwiseMax(p);
      const Vec3 more = (max_ - min_) * 0.01;
      min_ -= more, max_ += more;
    }
    if (!((max_ - min_).array() > 0).all()) throw ComponentError("the box has no volume", "min below max");
    double nodes = 1;
    for (std::size_t a = 0; a < 3; ++a) {
      if (data().find(std::string("n") + "xyz"[a])->isSet()) n_[a] = counts_[a];
      const double by_width = width_ > 0 ? std::max(2., std::ceil((max_ - min_)[Index(a)] / width_) + 1) : n_[a];
      nodes *= by_width;
      n_[a] = int(std::min(by_width, 1e9));
    }
    constexpr double most = 1e7, most_with_finer = 2e8;
    if (nodes > most || nodes * std::pow(8., finer_) > most_with_finer)
      throw ComponentError("the grid has too many cells",
                           fmt::format("at most {:g}, and {:g} with those of finer levels", most, most_with_finer));
  }

  void fill(const std::vector<Vec3>& surface) {
    const int parts = 1 << finer_;
    const std::array<int, 3> coarse{n_[0] - 1, n_[1] - 1, n_[2] - 1};
    Cells fine({coarse[0] * parts, coarse[1] * parts, coarse[2] * parts}, min_, max_);
    for (const Triangle& t : triangles_) fine.markBorder({surface[t[0]], surface[t[1]], surface[t[2]]});
    fine.markOutside();
    std::vector<std::array<int, 3>> border, inside;
    std::vector<double> border_factors;
    for (int k = 0; k < coarse[2]; ++k)
      for (int j = 0; j < coarse[1]; ++j)
        for (int i = 0; i < coarse[0]; ++i) {
          int cut = 0, out = 0;
          for (int c = 0; c < parts * parts * parts; ++c) {
            const Place place = fine.at(i * parts + c % parts, j * parts + c / parts % parts, k * parts + c / parts / parts);
            cut += place == Place::border, out += place == Place::outside;
          }
          const int all = parts * parts * parts;
          if (out == all) continue;
          if (cut + out == 0) {
            inside.push_back({i, j, k});
          } else if (!only_inside_) {
            border.push_back({i, j, k});
            border_factors.push_back(weighted_ ? (all - out - 0.5 * cut) / all : 1);
          }
        }
    factors_ = border_factors;
    factors_.resize(border.size() + inside.size(), 1.0);
    border.insert(border.end(), inside.begin(), inside.end());
    if (border.empty()) throw ComponentError("no cell lies in the surface", "more nodes, or a closed surface");
    makeMesh(border);
  }

  void makeMesh(const std::vector<std::array<int, 3>>& cells) {
    constexpr int corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    std::vector<std::array<int, 3>> nodes;
    const auto nodeOf = [&](const std::array<int, 3>& cell, const int* c) {
      return std::array<int, 3>{cell[0] + c[0], cell[1] + c[1], cell[2] + c[2]};
    };
    for (const auto& cell : cells)
      for (const auto& c : corner) nodes.push_back(nodeOf(cell, c));
    std::sort(nodes.begin(), nodes.end());  // by x, then y, then z
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    const Vec3 size = (max_ - min_).cwiseQuotient(Vec3(n_[0] - 1, n_[1] - 1, n_[2] - 1));
    mesh_ = Mesh();
    for (const auto& node : nodes) mesh_.position.push_back(min_ + size.cwiseProduct(Vec3(node[0], node[1], node[2])));
    for (const auto& cell : cells) {
      Hexahedron hexahedron;
      for (std::size_t c = 0; c < 8; ++c)
        hexahedron[c] = Index(std::lower_bound(nodes.begin(), nodes.end(), nodeOf(cell, corner[c])) - nodes.begin());
      mesh_.hexahedra.push_back(hexahedron);
    }
  }

  /// Cells that have another volume than the closed surface are stiffer, or softer, by as much at least.
  void tellVolume(const std::vector<Vec3>& surface) const {
    constexpr double much = 0.03, closed = 1e-6;
    double enclosed = 0, area = 0, factors = 0;
    Vec3 outward = Vec3::Zero();
    for (const Triangle& t : triangles_) {
      const Vec3 &a = surface[t[0]], &b = surface[t[1]], &c = surface[t[2]], normal = (b - a).cross(c - a);
      enclosed += (a - min_).dot((b - min_).cross(c - min_)) / 6, area += normal.norm(), outward += normal;
    }
    enclosed = std::abs(enclosed);
    if (outward.norm() > closed * area || !(enclosed > 0)) return;
    for (const double factor : factors_) factors += factor;
    const double cell = (max_ - min_).cwiseQuotient(Vec3(n_[0] - 1, n_[1] - 1, n_[2] - 1)).prod();
    const double all = cell * double(factors_.size()) / enclosed, weighted = cell * factors / enclosed;
    if (std::abs(all - 1) <= much && std::abs(weighted - 1) <= much) return;
    inform(fmt::format(
        "its cells have {:.0f} % of the volume of the surface, and with cellFactors {:.0f} %: a body of them is stiffer or softer "
        "than the one in the surface, most where it bends{}",
        100 * all, 100 * weighted,
        weighted_ && finer_ < 3 ? ". nbVirtualFinerLevels=\"3\" counts better what cells on the border hold" : ""));
  }

  std::array<int, 3> n_{2, 2, 2}, counts_{2, 2, 2};
  Vec3 min_ = Vec3::Zero(), max_ = Vec3::Zero();
  double width_ = 0;
  int finer_ = 0;
  bool only_inside_ = false, weighted_ = true;
  std::vector<Triangle> triangles_;
  std::vector<Quad> quads_;
  std::vector<double> factors_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(sparse_grid_topology) {
  factory.add<stroma::SparseGridTopology>("SparseGridTopology", "the cells of a box that lie in a surface");
}
