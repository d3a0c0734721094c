// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/scene/types.h"

namespace stroma {

class State;

/// Implemented by force fields that connect pairs of nodes, so that a viewer can draw them: they are not part of the mesh
/// of a body.
class DrawnSegments {
 public:
  /// Two nodes, each of its own state. The states may belong to two systems, or to none.
  struct Segment {
    const State* first;
    Index first_node;
    const State* second;
    Index second_node;
    double radius = 0;  ///< radius of a beam between two frames, drawn as a curve [m]; 0: a straight line
    bool operator==(const Segment&) const = default;
  };
  virtual ~DrawnSegments() = default;
  /// Appends one segment per pair, in the order of the elements. Called after init(), and again after attributes have
  /// changed.
  virtual void addSegments(std::vector<Segment>& segments) const = 0;
};

/// Implemented by components that make a body solid to others. A viewer draws them even if nothing moves them.
class DrawnSolids {
 public:
  struct Sphere {
    const State* state;
    Index node;
    double radius;  ///< [m]
  };
  virtual ~DrawnSolids() = default;
  virtual void addSolids(std::vector<const State*>& bodies, std::vector<Sphere>& spheres) const = 0;
};

/// Implemented by components with solids that belong to no state: obstacles, which move together.
class DrawnObstacles {
 public:
  struct Shape {
    std::vector<Vec3> points;           ///< of triangles; otherwise one point, or the two ends of an axis [m]
    std::vector<Triangle> triangles{};  ///< empty: a sphere or a capsule of `radius`
    double radius = 0;                  ///< [m]
    Vec3 normal = Vec3::Zero();         ///< not zero: a plane through the point
  };
  virtual ~DrawnObstacles() = default;
  virtual void addShapes(std::vector<Shape>& shapes) const = 0;
  virtual Vec3 shapesMovedBy() const = 0;  ///< now [m]
  virtual void showShapesAt(double) {}     ///< the time of a recording [s]
};

}  // namespace stroma
