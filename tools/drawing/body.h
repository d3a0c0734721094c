// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "framework/mechanics/drawn_segments.h"
#include "framework/mechanics/frames.h"
#include "framework/mesh/mesh.h"
#include "framework/simulation/simulation.h"
#include "framework/simulation/system.h"

namespace stroma::drawing {

/// A round beam between two frames.
struct Beam {
  std::array<Index, 2> nodes{};   ///< page numbers of its ends
  std::array<Index, 2> frames{};  ///< in Body::frames
  double radius = 0;              ///< [m]
  std::array<Vec3, 2> chord{};    ///< from end to end at rest, in the axes of each [m]
};

struct Ball {
  Index node = 0;     ///< page number of its centre
  double radius = 0;  ///< [m]
};

/// The drawn parts of a state. Its nodes are renumbered for drawing: those of the surface come first, so that the positions
/// of the surface are the start of those of all nodes. "Page number" means that number below.
struct Body {
  const State* state = nullptr;
  const System* system = nullptr;  ///< null: nothing moves the state
  const Mesh* mesh = nullptr;  ///< that of its cells; null for a state without one
  std::vector<Index> node;     ///< number in the state of each page number; rows that are places only
  std::vector<Index> page;     ///< the other way; -1 for a row that is not a place
  Index surface = 0;           ///< how many are on the surface

  std::vector<Triangle> triangles;  ///< page numbers, counter-clockwise from outside
  std::vector<Index>
      owner;                ///< cell of each triangle, volume cells as their lists follow each other; without those, triangles, then quads
  std::vector<Edge> edges;  ///< of the faces, without diagonals of quads; or the lines
  std::vector<Index> points;                 ///< nodes that nothing else draws
  std::vector<Edge> springs;                 ///< within the body
  std::vector<Beam> beams;                   ///< in the place of edges
  std::vector<Ball> balls;                   ///< in the place of points; a body with faces or beams has none
  std::vector<std::array<Index, 2>> frames;  ///< rigid frames: page number of the place, row of the turn in the state
  double axis = 0;                           ///< length of the drawn axes of a frame [m]
  double size = 0;  ///< diagonal of the box around it at rest, of the scene's for what is one point; never zero [m]
  std::shared_ptr<const Vector> standing;  ///< without a system: where its rows stand, then as many zeros

  /// Cells that fields may have a value for: volume cells, else triangles and quads.
  Index cells() const;
  /// The rows of the state now.
  ConstRows x() const { return system ? ConstRows(state->x()) : ConstRows(*standing).head(state->size()); }
  ConstRows v() const {
    return system ? ConstRows(state->v()) : ConstRows(*standing).segment(state->size(), state->size());
  }
};

/// `pieces` + 1 places along a beam whose ends are at a and b with these orientations: a cubic that leaves each end along the
/// direction in which the beam is fixed to it.
std::vector<Vec3> beamCurve(const Beam& beam, const Vec3& a, const Vec3& b, const Quaternion& turn_a, const Quaternion& turn_b,
                            int pieces);

/// A spring or a tie between two bodies.
struct BodyLink {
  Index body_a = 0, node_a = 0, body_b = 0, node_b = 0;  ///< nodes by page number
  bool is_tie = false;
};

/// A field that a body may be coloured by.
struct Field {
  int id = 0;
  Index body = 0;
  std::string name;
  const ForceField* source = nullptr;  ///< of a field of cells; null: a field of nodes
  const Data* data = nullptr;          ///< of a field of nodes that a component computes; null: the velocity
};

/// The obstacles of a component as triangles, where they are written. They move together.
struct Obstacle {
  const Component* owner = nullptr;
  const DrawnObstacles* drawn = nullptr;
  std::vector<Vec3> points;         ///< [m]
  std::vector<Triangle> triangles;  ///< planes come last
  std::size_t solid = 0;            ///< triangles before those of planes
};

/// A component that computes forces of contact.
struct Contact {
  const Component* owner = nullptr;
  Index body = -1;                    ///< whose nodes have the forces; -1: they are between nodes
  std::vector<std::string> bodies{};  ///< paths of the states that its sums are of
};

/// A simulation as a page or a picture draws it. Made once for a scene.
struct Drawing {
  std::vector<Body> bodies;
  std::vector<BodyLink> links;
  std::vector<Field> fields;
  std::vector<Obstacle> obstacles;
  std::vector<Contact> contacts;
};
Drawing drawingOf(const Simulation& simulation);
/// Obstacles, for the bodies that there are.
void addObstacles(const Simulation& simulation, Drawing& drawing);
/// The pairs of nodes that force fields join: the part of a drawing that an edit can change.
std::vector<DrawnSegments::Segment> segmentsOf(const Simulation& simulation);

/// The values of a field of cells at the present positions, one for each of body.cells(), NaN for cells that the force field
/// does not have. Of a field of vectors or tensors, their norms; six numbers are a symmetric tensor xx yy zz xy yz zx. False
/// when the field fits no list of the body's cells. `work` is scratch space.
bool cellValues(const Field& field, const Body& body, std::vector<double>& work, std::vector<float>& out);

/// "Pa" for stresses and pressures, "-" for pure numbers, empty when not known.
std::string unitOfField(const std::string& name);
std::string unitOf(const Field& field);

}  // namespace stroma::drawing
