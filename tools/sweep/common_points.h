// SPDX-License-Identifier: LGPL-2.1-or-later
// Where runs with different meshes are compared: the Gauss points of one body's cells at rest, with the volumes that they
// stand for; or points of a file.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "tools/sweep/cell_finder.h"

namespace stroma::sweep {

class CommonPoints {
 public:
  CommonPoints() = default;
  /// Gauss points of all volume cells, or the nodes of a body that has none.
  explicit CommonPoints(const EndState& end);
  /// These places, each as important.
  explicit CommonPoints(std::vector<Vec3> places);

  std::size_t size() const { return places_.size(); }
  const std::vector<Vec3>& places() const { return places_; }
  const std::vector<double>& weights() const { return weights_; }

  /// Displacements there [m], interpolated by the shape functions of the cells. Throws std::runtime_error with a
  /// sentence when a body is missing, or has no cells and other nodes.
  std::vector<Vec3> displacements(const EndState& end) const;
  /// Of the last displacements(): how many points lay outside of the mesh, and the farthest by how much [m].
  std::size_t outside() const { return outside_; }
  double farthestOutside() const { return farthest_; }

 private:
  struct Group {
    std::string body;  ///< path of the state; empty: whichever is nearest
    std::size_t first = 0, count = 0;
    bool are_nodes = false;
  };
  struct Placing {
    std::vector<Place> places;  ///< shape (points)
    std::vector<int> bodies;    ///< of each point
    std::size_t outside = 0;
    double farthest = 0;
  };
  const Placing& placingIn(const EndState& end) const;
  void place(const EndState& end, const Group& group, Placing& placing) const;

  std::vector<Vec3> places_;
  std::vector<double> weights_;
  std::vector<Group> groups_;
  /// By meshes: many runs share one.
  mutable std::map<std::string, Placing> placings_;
  mutable std::size_t outside_ = 0;
  mutable double farthest_ = 0;
};

}  // namespace stroma::sweep
