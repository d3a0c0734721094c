// SPDX-License-Identifier: LGPL-2.1-or-later
// What grids of the cells in a surface share (sparse_grid_topology.cpp says what they are).
#pragma once
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "components/topology/sparse_grid_cells.h"
#include "framework/mesh/cell_attributes.h"
#include "framework/mesh/topology.h"

namespace stroma {

class SparseGridTopology : public Topology {
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
    table.add("partLevels", part_levels_)
        .help("into how many parts partFactors divides a cell: 2 to this power along each axis")
        .min(0)
        .max(4);
    table.add("onlyInsideCells", only_inside_).help("no cells on the border");
    table.add("fillWeighted", weighted_).help("cells on the border have a factor below 1");
    addCellList(table, cell_kinds::hexahedron, mesh_.hexahedra).help("the cells").output();
    table.add("cellFactors", factors_).help("how much of each cell is filled").unit("-").output();
    table.add("partFactors", part_factors_).help("how much of each part of each cell is filled").unit("-").output();
    for (const char* name : {"facets", "computeHexaList", "convolutionSize", "marchingCubeStep", "dataResolution", "voxelSize"})
      table.addVisualOnly(name);
  }

  void init() override {
    gather();
    const std::vector<Vec3> surface = mesh_.position;
    if (surface.empty() || triangles_.empty())
      throw ComponentError("there is no surface to fill", "position and triangles, as by src=\"@loader\"");
    for (const Triangle& t : triangles_)
      for (const Index node : t)
        if (node < 0 || std::size_t(node) >= surface.size())
          throw ComponentError(fmt::format("a triangle names node {} of {}", node, surface.size()));
    if (part_levels_ > finer_)
      throw ComponentError(fmt::format("partLevels is {}, and the surface is looked at on {} finer levels", part_levels_, finer_),
                           fmt::format("nbVirtualFinerLevels=\"{}\" or more", part_levels_));
    findBox(surface);
    fill(surface);
    tellVolume(surface);
  }

 protected:
  using Cells = sparse_grid::Cells;
  virtual bool splitsCells() const { return false; }
  virtual bool looksAtTriangles() const { return false; }
  /// Writes the nodes and the triangles of what is filled.
  virtual void gather() {
    for (const Quad& q : quads_) triangles_.push_back({q[0], q[1], q[2]}), triangles_.push_back({q[0], q[2], q[3]});
  }
  virtual void mark(const std::vector<Vec3>& surface, Cells& fine) {
    markTriangles(surface, 0, triangles_.size(), fine);
    fine.markOutside();
  }
  void markTriangles(const std::vector<Vec3>& surface, std::size_t first, std::size_t end, Cells& fine) const {
    for (std::size_t t = first; t < end; ++t) {
      const Triangle& corners = triangles_[t];
      fine.markBorder({surface[corners[0]], surface[corners[1]], surface[corners[2]]}, int(t));
    }
  }
  /// Factors of the stiffness and the mass of a cell of the finest level that is not outside.
  virtual std::array<double, 2> factorsOf(std::size_t, bool is_cut) const {
    const double factor = is_cut && weighted_ ? 0.5 : 1;
    return {factor, factor};
  }
  /// Whether cells that are full have the factors 1.
  virtual bool isUniform() const { return true; }

  bool weighted_ = true;
  std::vector<Triangle> triangles_;
  std::vector<double> factors_, part_factors_, mass_factors_, part_mass_factors_;

 private:
  using Place = sparse_grid::Place;
  using Sets = sparse_grid::Sets;
  using GridPlace = std::array<int, 3>;
  static constexpr int cube_corners[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                             {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  static GridPlace cornerOf(const GridPlace& cell, const int* by) { return {cell[0] + by[0], cell[1] + by[1], cell[2] + by[2]}; }
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
    const double most = 1e7, most_with_finer = splitsCells() ? 2e7 : 2e8;  // each of those that are split takes 40 bytes
    const auto check = [](double count, double limit, const std::string& of_what) {
      if (count > limit)
        throw ComponentError(fmt::format("the grid has too many {}: {:.3g}", of_what, count), fmt::format("at most {:g}", limit));
    };
    check(nodes, most, "cells");
    check(nodes * std::pow(8., finer_), most_with_finer, fmt::format("cells of nbVirtualFinerLevels=\"{}\"", finer_));
    check(nodes * std::pow(8., part_levels_), most, fmt::format("parts of cells of partLevels=\"{}\"", part_levels_));
  }

  /// A cell of the grid, or a copy of it.
  struct Cell {
    GridPlace at;
    bool is_border = false;
    std::vector<std::size_t> fine{};                          ///< cells of the finest level, of copies alone
    std::array<double, 2> factor{};                           ///< of stiffness and mass
    std::array<std::vector<double>, 2> parts{};               ///< the same of its parts
  };

  void fill(const std::vector<Vec3>& surface) {
    const int parts = 1 << finer_;
    const GridPlace coarse{n_[0] - 1, n_[1] - 1, n_[2] - 1};
    Cells fine({coarse[0] * parts, coarse[1] * parts, coarse[2] * parts}, min_, max_);
    if (splitsCells() && looksAtTriangles()) fine.keepTriangles();
    mark(surface, fine);
    std::vector<Cell> cells;
    for (int k = 0; k < coarse[2]; ++k)
      for (int j = 0; j < coarse[1]; ++j)
        for (int i = 0; i < coarse[0]; ++i) addCell({i, j, k}, parts, fine, cells);
    std::stable_partition(cells.begin(), cells.end(), [](const Cell& cell) { return cell.is_border; });
    if (cells.empty()) throw ComponentError("no cell lies in the surface", "more nodes, or a closed surface");
    std::vector<double>* all[2][2] = {{&factors_, &part_factors_}, {&mass_factors_, &part_mass_factors_}};
    for (std::size_t of = 0; of < 2; ++of) {
      for (std::vector<double>* list : all[of]) list->clear();
      for (const Cell& cell : cells) {
        all[of][0]->push_back(cell.factor[of]);
        all[of][1]->insert(all[of][1]->end(), cell.parts[of].begin(), cell.parts[of].end());
      }
    }
    if (splitsCells())
      makeSplitMesh(cells, parts, fine);
    else
      makeMesh(cells);
  }

  void addCell(const GridPlace& at, int parts, Cells& fine, std::vector<Cell>& cells) const {
    const int all = parts * parts * parts;
    const auto fineAt = [&](int c) {
      return fine.index(at[0] * parts + c % parts, at[1] * parts + c / parts % parts, at[2] * parts + c / parts / parts);
    };
    const bool splits = splitsCells();
    Sets groups(splits ? std::size_t(all) : 0);
    for (int c = 0; splits && c < all; ++c)
      for (const auto& [is_inner, step] : {std::pair(c % parts + 1 < parts, 1), std::pair(c / parts % parts + 1 < parts, parts),
                                           std::pair(c / parts / parts + 1 < parts, parts * parts)})
        if (is_inner && fine.areNeighbours(fineAt(c), fineAt(c + step))) groups.join(std::size_t(c), std::size_t(c + step));
    const auto groupOf = [&](int c) { return splits ? int(groups.find(std::size_t(c))) : 0; };
    for (int first = 0; first < (splits ? all : 1); ++first) {
      if (groupOf(first) != first || (splits && fine.placeOf(fineAt(first)) == Place::outside)) continue;
      Cell cell{at};
      int cut = 0, inside = 0;
      const int along = 1 << part_levels_, each = parts / along;
      for (auto& parts_of : cell.parts) parts_of.assign(std::size_t(along * along * along), 0);
      for (int c = first; c < all; ++c) {
        const std::size_t index = fineAt(c);
        if (fine.placeOf(index) == Place::outside || groupOf(c) != first) continue;
        const bool is_cut = fine.placeOf(index) == Place::border;
        ++(is_cut ? cut : inside);
        const int part = c % parts / each + along * (c / parts % parts / each + along * (c / parts / parts / each));
        const std::array<double, 2> factors = factorsOf(index, is_cut);
        for (std::size_t of = 0; of < 2; ++of) {
          cell.parts[of][std::size_t(part)] += factors[of] / (each * each * each);
          cell.factor[of] += factors[of] / all;
        }
        if (splits) cell.fine.push_back(index);
      }
      if (cut + inside == 0) continue;
      cell.is_border = inside < all;
      if (cell.is_border && only_inside_) continue;
      if (isUniform() && (!cell.is_border || !weighted_)) cell.factor = {1, 1};
      for (std::size_t of = 0; part_levels_ == 0 && of < 2; ++of) cell.parts[of][0] = cell.factor[of];
      cells.push_back(std::move(cell));
    }
  }

  Vec3 placeOf(const GridPlace& node) const {
    return min_ + (max_ - min_).cwiseQuotient(Vec3(n_[0] - 1, n_[1] - 1, n_[2] - 1)).cwiseProduct(Vec3(node[0], node[1], node[2]));
  }

  void makeMesh(const std::vector<Cell>& cells) {
    std::vector<GridPlace> nodes;
    for (const Cell& cell : cells)
      for (const auto& corner : cube_corners) nodes.push_back(cornerOf(cell.at, corner));
    std::sort(nodes.begin(), nodes.end());  // by x, then y, then z
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    mesh_ = Mesh();
    for (const GridPlace& node : nodes) mesh_.position.push_back(placeOf(node));
    for (const Cell& cell : cells) {
      Hexahedron hexahedron;
      for (std::size_t c = 0; c < 8; ++c)
        hexahedron[c] = Index(std::lower_bound(nodes.begin(), nodes.end(), cornerOf(cell.at, cube_corners[c])) - nodes.begin());
      mesh_.hexahedra.push_back(hexahedron);
    }
  }

  /// Corners of copies are one node where fine cells of both are neighbours.
  void makeSplitMesh(const std::vector<Cell>& cells, int parts, const Cells& fine) {
    constexpr std::size_t none = std::size_t(-1);
    std::vector<std::size_t> copy_of(fine.size(), none);
    for (std::size_t copy = 0; copy < cells.size(); ++copy)
      for (const std::size_t index : cells[copy].fine) copy_of[index] = copy;
    Sets corners(8 * cells.size());
    const std::size_t nx = std::size_t((n_[0] - 1) * parts), ny = std::size_t((n_[1] - 1) * parts);
    const std::size_t steps[3] = {1, nx, nx * ny};
    const auto coordinate = [&](std::size_t index, std::size_t axis) {
      return axis == 0 ? index % nx : axis == 1 ? index / nx % ny : index / (nx * ny);
    };
    for (std::size_t copy = 0; copy < cells.size(); ++copy)
      for (const std::size_t index : cells[copy].fine)
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if (coordinate(index, axis) + 1 == std::size_t((n_[axis] - 1) * parts)) continue;
          const std::size_t next = copy_of[index + steps[axis]];
          if (next == none || next == copy || !fine.areNeighbours(index, index + steps[axis])) continue;
          if (cells[next].at == cells[copy].at) continue;
          for (std::size_t a = 0; a < 8; ++a)
            for (std::size_t b = 0; b < 8; ++b)
              if (cornerOf(cells[copy].at, cube_corners[a]) == cornerOf(cells[next].at, cube_corners[b]))
                corners.join(8 * copy + a, 8 * next + b);
        }
    std::vector<std::pair<GridPlace, std::size_t>> nodes;
    for (std::size_t c = 0; c < 8 * cells.size(); ++c)
      if (corners.find(c) == c) nodes.emplace_back(cornerOf(cells[c / 8].at, cube_corners[c % 8]), c);
    std::sort(nodes.begin(), nodes.end());
    std::vector<Index> number(8 * cells.size());
    mesh_ = Mesh();
    for (const auto& [place, corner] : nodes) {
      number[corner] = Index(mesh_.position.size());
      mesh_.position.push_back(placeOf(place));
    }
    for (std::size_t copy = 0; copy < cells.size(); ++copy) {
      Hexahedron hexahedron;
      for (std::size_t c = 0; c < 8; ++c) hexahedron[c] = number[corners.find(8 * copy + c)];
      mesh_.hexahedra.push_back(hexahedron);
    }
  }

  /// Cells that have another volume than the closed surface are stiffer, or softer, by as much at least.
  void tellVolume(const std::vector<Vec3>& surface) const {
    if (!isUniform()) return;
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
  int finer_ = 0, part_levels_ = 0;
  bool only_inside_ = false;
  std::vector<Quad> quads_;
};

}  // namespace stroma
