// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/mappings/cell_centres.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace stroma {
namespace {

constexpr double thickness = 0.01;   ///< of a surface, in units of its u across
constexpr double round_off = 1e-12;  ///< volume of a cell over the product of its edges that is round-off
constexpr double many = 125;         ///< keys of one cell, from which on it is asked by every look
constexpr double last_key = 1e15;    ///< of either sign: coordinates beyond have no digits for more
using Key = std::array<long long, 3>;

struct Cell {
  std::vector<Index> nodes;
  Mat3 to_affine;  ///< u = to_affine (p - corner 0)
  Vec3 first, centre, low, high;
  bool is_flat = false;  ///< no coordinates u: it holds no point
};

bool isSurface(const Cell& cell, bool has_volume) { return !has_volume && cell.nodes.size() <= 4; }

/// Not positive in the cell.
double depthOf(const Cell& cell, const Vec3& u, bool has_volume) {
  const bool is_simplex = cell.nodes.size() == (has_volume ? 4 : 3);
  if (isSurface(cell, has_volume)) {
    const double far = is_simplex ? u[0] + u[1] - 1 : std::max(u[0], u[1]) - 1;
    return std::max({-u[0], -u[1], std::abs(u[2]) - thickness, far});
  }
  return std::max({-u[0], -u[1], -u[2], is_simplex ? u.sum() - 1 : u.maxCoeff() - 1});
}

std::vector<double> weightsOf(const Cell& cell, const Vec3& u, bool has_volume) {
  const double x = u[0], y = u[1], z = u[2];
  if (!has_volume && cell.nodes.size() == 3) return {1 - x - y, x, y};
  const std::vector<double> flat{(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y};
  if (!has_volume) return flat;
  if (cell.nodes.size() == 4) return {1 - x - y - z, x, y, z};
  std::vector<double> weights;
  for (const double level : {1 - z, z})
    for (const double weight : flat) weights.push_back(weight * level);
  return weights;
}

template <class List>
void addCells(const List& list, const std::vector<Vec3>& body, bool has_volume, std::vector<Cell>& cells) {
  for (const auto& nodes : list) {
    Cell cell{{nodes.begin(), nodes.end()}, {}, body[std::size_t(nodes[0])], Vec3::Zero(), {}, {}};
    cell.low = cell.high = cell.first;
    for (const Index node : nodes) {
      const Vec3& p = body[std::size_t(node)];
      cell.centre += p / double(nodes.size());
      cell.low = cell.low.cwiseMin(p);
      cell.high = cell.high.cwiseMax(p);
    }
    const bool is_simplex = nodes.size() == (has_volume ? 4u : 3u);
    const auto edge = [&](std::size_t corner) -> Vec3 { return body[std::size_t(nodes[corner])] - cell.first; };
    Mat3 edges;
    edges.col(0) = edge(1), edges.col(1) = edge(is_simplex ? 2 : 3);
    edges.col(2) = has_volume ? edge(is_simplex ? 3 : 4) : Vec3(edges.col(0).cross(edges.col(1)));
    const double lengths = edges.col(0).norm() * edges.col(1).norm() * edges.col(2).norm();
    cell.is_flat = !(std::abs(edges.determinant()) > round_off * lengths);
    cell.to_affine = cell.is_flat ? Mat3(Mat3::Zero()) : Mat3(edges.inverse());
    cell.is_flat = cell.is_flat || !cell.to_affine.allFinite();
    cells.push_back(std::move(cell));
  }
}

/// Of the mesh's edges, or of those of its cells; hexahedra and quads have theirs between neighbours alone.
double meanEdge(const Mesh& mesh, const std::vector<Cell>& cells, const std::vector<Vec3>& body, bool has_volume) {
  std::set<std::pair<Index, Index>> edges;
  for (const Edge& edge : mesh.edges) edges.insert({edge[0], edge[1]});
  const bool given = !edges.empty();
  for (const Cell& cell : cells) {
    const std::size_t count = cell.nodes.size();
    const bool is_simplex = count == (has_volume ? 4u : 3u);
    for (std::size_t a = 0; a < count && !given; ++a)
      for (std::size_t b = a + 1; b < count; ++b) {
        const bool is_side = a / 4 == b / 4 && (b - a) % 2 == 1, is_upright = b == a + 4;
        if (is_simplex || is_side || is_upright) edges.insert(std::minmax(cell.nodes[a], cell.nodes[b]));
      }
  }
  double sum = 0;
  for (const auto& [a, b] : edges) sum += (body[std::size_t(a)] - body[std::size_t(b)]).norm();
  return sum / double(edges.size());
}

/// Where a point lies that no cell holds.
enum class Outside { near_by, nearest_centre, nearest_box };

class Search {
 public:
  /// A grid of cells as wide as `width` holds the boxes of the cells; those that would take many of its cells are listed apart.
  Search(std::vector<Cell> cells, bool has_volume, Outside outside, double width)
      : cells_(std::move(cells)), has_volume_(has_volume), outside_(outside), width_(width) {
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      const Key low = keyOf(cells_[c].low), high = keyOf(cells_[c].high);
      double count = 1;
      for (std::size_t a = 0; a < 3; ++a) count *= double(high[a] - low[a]) + 1;
      if (count > many) {
        large_.push_back(c);
        continue;
      }
      for (long long x = low[0]; x <= high[0]; ++x)
        for (long long y = low[1]; y <= high[1]; ++y)
          for (long long z = low[2]; z <= high[2]; ++z) table_[{x, y, z}].push_back(c);
    }
  }
  EmbeddedPoint find(const Vec3& point) {
    best_ = none;
    distance_ = std::numeric_limits<double>::max();
    const Key key = keyOf(point);
    if (has_volume_ || outside_ == Outside::near_by) look(key, point);
    if (outside_ != Outside::near_by && distance_ > 0) {
      best_ = none;
      distance_ = std::numeric_limits<double>::max();
    }
    if (outside_ == Outside::near_by && best_ != none && std::abs(distance_) > width_ / 2)
      for (long long x = -1; x <= 1; ++x)
        for (long long y = -1; y <= 1; ++y)
          for (long long z = -1; z <= 1; ++z) look({key[0] + x, key[1] + y, key[2] + z}, point);
    if (best_ == none && has_volume_ && outside_ != Outside::near_by) {
      takeNearest(point);
    } else if (best_ == none) {
      for (std::size_t c = 0; c < cells_.size(); ++c) look(c, point);
    }
    EmbeddedPoint found;
    if (best_ == none) return found;
    const Cell& cell = cells_[best_];
    found.distance = distance_ > 0 ? (point - point.cwiseMax(cell.low).cwiseMin(cell.high)).norm() : 0;
    found.nodes = cell.nodes;
    found.weights = weightsOf(cell, u_, has_volume_);
    return found;
  }

 private:
  static constexpr std::size_t none = std::size_t(-1);
  Key keyOf(const Vec3& p) const {
    Key key;
    for (std::size_t a = 0; a < 3; ++a) {
      const double place = std::floor(p[Index(a)] / width_);
      key[a] = std::isnan(place) ? 0 : static_cast<long long>(std::clamp(place, -last_key, last_key));
    }
    return key;
  }
  bool meets(std::size_t c, const Key& key) const {
    const Key low = keyOf(cells_[c].low), high = keyOf(cells_[c].high);
    for (std::size_t a = 0; a < 3; ++a)
      if (key[a] < low[a] || key[a] > high[a]) return false;
    return true;
  }
  /// Cells in the order of their numbers: of those that hold a point alike the first counts.
  void look(const Key& key, const Vec3& point) {
    auto large = large_.begin();
    const auto lookBefore = [&](std::size_t end) {
      for (; large != large_.end() && *large < end; ++large)
        if (meets(*large, key)) look(*large, point);
    };
    if (const auto entry = table_.find(key); entry != table_.end())
      for (const std::size_t cell : entry->second) lookBefore(cell), look(cell, point);
    lookBefore(cells_.size());
  }
  void look(std::size_t c, const Vec3& point) {
    const Cell& cell = cells_[c];
    const Vec3 u = cell.to_affine * (point - cell.first);
    double distance = depthOf(cell, u, has_volume_);
    if (distance > 0) distance = (point - cell.centre).squaredNorm();
    if (distance < distance_) {
      distance_ = distance;
      best_ = c;
      u_ = u;
    }
  }

  /// No cell holds the point. Of boxes that are as near the last one counts, as in a grid.
  void takeNearest(const Vec3& point) {
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      const Cell& cell = cells_[c];
      const bool by_box = outside_ == Outside::nearest_box;
      const Vec3 place = by_box ? Vec3(point.cwiseMax(cell.low).cwiseMin(cell.high)) : cell.centre;
      const double distance = (point - place).squaredNorm();
      if (distance < distance_ || (by_box && distance == distance_)) {
        distance_ = distance;
        best_ = c;
      }
    }
    if (best_ != none) u_ = cells_[best_].to_affine * (point - cells_[best_].first);
  }

  std::vector<Cell> cells_;
  bool has_volume_;
  Outside outside_;
  double width_;
  std::map<Key, std::vector<std::size_t>> table_;
  std::vector<std::size_t> large_;  ///< cells that the table leaves out
  std::size_t best_ = none;         ///< of the last search, with its distance and place
  double distance_ = 0;
  Vec3 u_ = Vec3::Zero();
};

bool isSet(const Topology& topology) { return topology.type().ends_with("SetTopologyContainer"); }
bool isGrid(const Topology& topology) { return topology.type() == "RegularGridTopology"; }

}  // namespace

bool findsByCentres(const Topology& topology) {
  const Mesh& mesh = topology.mesh();
  const bool has_cells =
      !mesh.tetrahedra.empty() || !mesh.hexahedra.empty() || !mesh.triangles.empty() || !mesh.quads.empty();
  if (isGrid(topology)) return !mesh.hexahedra.empty();
  return has_cells && mesh.prisms.empty() && mesh.pyramids.empty() && !topology.type().starts_with("SparseGrid");
}

std::vector<EmbeddedPoint> embedByCentres(const Topology& topology, const std::vector<Vec3>& body,
                                          const std::vector<Vec3>& points, double& size) {
  const Mesh& mesh = topology.mesh();
  const bool has_volume = !mesh.tetrahedra.empty() || !mesh.hexahedra.empty();
  std::vector<Cell> cells;
  if (has_volume) {
    addCells(mesh.tetrahedra, body, true, cells), addCells(mesh.hexahedra, body, true, cells);
  } else {
    addCells(mesh.triangles, body, false, cells), addCells(mesh.quads, body, false, cells);
  }
  Vec3 low = cells.front().low, high = cells.front().high;
  for (const Cell& cell : cells) {
    low = low.cwiseMin(cell.low);
    high = high.cwiseMax(cell.high);
  }
  size = (high - low).norm();
  const double width = meanEdge(mesh, cells, body, has_volume);
  const Outside outside = isSet(topology)    ? Outside::near_by
                          : isGrid(topology) ? Outside::nearest_box
                                             : Outside::nearest_centre;
  std::erase_if(cells, [](const Cell& cell) { return cell.is_flat; });
  Search search(std::move(cells), has_volume, outside, width);
  std::vector<EmbeddedPoint> found;
  for (const Vec3& point : points) found.push_back(search.find(point));
  return found;
}

}  // namespace stroma
