// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/scene/types.h"

namespace stroma {

class State;

/// Implemented by force fields that join pairs of nodes, so that a viewer can draw them: they are not in the mesh of a
/// body.
class DrawnSegments {
 public:
  /// Two nodes, each of its state. The states may be those of two systems, or one that nothing moves.
  struct Segment {
    const State* first;
    Index first_node;
    const State* second;
    Index second_node;
    double radius = 0;  ///< of a round beam between two frames [m], which bends from one to the other; 0: a line
    bool operator==(const Segment&) const = default;
  };
  virtual ~DrawnSegments() = default;
  /// Appends one segment for each pair, in the order of the field's elements; after init(), and again after a change of
  /// its attributes.
  virtual void addSegments(std::vector<Segment>& segments) const = 0;
};

/// Implemented by components that make a body solid to others: a viewer draws it even where nothing moves it.
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
    std::vector<Vec3> points;           ///< of triangles; else one, or two that are joined [m]
    std::vector<Triangle> triangles{};  ///< none: the points are rounded by `radius`
    double radius = 0;                  ///< [m]
    Vec3 normal = Vec3::Zero();         ///< not zero: a plane through the one point
  };
  virtual ~DrawnObstacles() = default;
  virtual void addShapes(std::vector<Shape>& shapes) const = 0;
  virtual Vec3 shapesMovedBy() const = 0;  ///< now [m]
  virtual void showShapesAt(double) {}     ///< of a recording: a time [s]
};

}  // namespace stroma
