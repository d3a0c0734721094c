// SPDX-License-Identifier: LGPL-2.1-or-later
// Selects the nodes and cells of a mesh that lie in a region. A region decides which points it contains.
#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <string>
#include <vector>

#include "framework/mesh/mesh.h"
#include "framework/scene/component.h"

namespace stroma {

class RegionOfInterest : public Component {
 public:
  std::string roleText() const override { return "selection"; }
  void declare(DataTable& table) override;
  void init() override;

 protected:
  virtual void prepare() = 0;  ///< checks the region; throws ComponentError
  virtual bool contains(const Vec3& p) const = 0;
  virtual std::string describeRegion() const = 0;
  /// Of an edge or a triangle that lies inside: whether it counts.
  virtual bool pointsRight(const Edge&) const { return true; }
  virtual bool pointsRight(const Triangle&) const { return true; }
  /// The distance [m] by which the border of a region of this size is moved outwards.
  double widened(double size) const {
    return exact_ ? 0 : widening * (around_.sizes().maxCoeff() > 0 ? std::min(size, around_.sizes().maxCoeff()) : size);
  }
  bool isIn(const Vec3& low, const Vec3& high, const Vec3& p) const {
    const double border = widened((high - low).maxCoeff());
    return (p.array() >= low.array() - border).all() && (p.array() <= high.array() + border).all();
  }
  static constexpr double widening = 1e-9;

  std::vector<Vec3> position_;  ///< of the nodes tested [m]
  bool strict_ = true;
  bool whole_counts_ = false;  ///< a cell whose nodes are all inside is inside, too, where its centre is asked

 private:
  template <class Cell>
  struct Selection {
    std::vector<Cell> cells, inside_cells, outside_cells;  ///< `cells`: tested
    std::vector<int> indices, outside;
    bool wanted = true;
  };
  struct Selections {
    Selection<Edge> edges;
    Selection<Triangle> triangles;
    Selection<Quad> quads;
    Selection<QuadraticTriangle> quadratic_triangles;
    Selection<Tetrahedron> tetrahedra;
    Selection<Hexahedron> hexahedra;
    Selection<Prism> prisms;
    Selection<Pyramid> pyramids;
    Selection<QuadraticTetrahedron> quadratic_tetrahedra;
  } cells_;
  void forget();
  void findPositions();
  void takeCells();
  template <class Cell>
  void select(Selection<Cell>& selection) const;
  [[noreturn]] void failEmpty() const;

  std::vector<Vec3> points_inside_, points_outside_;
  std::vector<int> indices_, outside_;
  int count_ = 0;
  bool allow_empty_ = false, update_ = false, exact_ = false;
  std::vector<char> inside_;    ///< of each node
  Eigen::AlignedBox3d around_;  ///< the nodes
};

}  // namespace stroma
