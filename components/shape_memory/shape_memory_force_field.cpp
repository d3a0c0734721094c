// SPDX-License-Identifier: LGPL-2.1-or-later
// ShapeMemoryForceField (Phymul): each node is drawn to the place that its neighbours remember for it.
//
// At rest a node lies at r from the mean of its neighbours. While the neighbours x_j move, with mean c and with the
// rotation R that fits their rest positions X_j to them best, the node's target and the force on it (a linear actuator
// force) are
//   P_target = c + R r,   F = k (P_target - P),   k = stiffness
// Neighbours are the nodes joined to it by an edge of a cell.
// Source: M. Nesme, M. Marchal, E. Promayon, M. Chabanas, Y. Payan, F. Faure, "Physically realistic interactive
// simulation for biological soft tissues", Recent Research Developments in Biomechanics 2, 2005 (section 4). It leaves
// open how the frame of a neighbourhood is found; here it is the best fit (frame = bestFit), or that of the three
// neighbours which span the largest triangle at rest (frame = triangle).
//
// The node itself counts in the fit with the weight ownWeight, so that the turn about neighbours that lie on a line is
// not arbitrary; with one or two neighbours, or crushed to a line or a point, every shape still has a target.
//
// reaction = true (the default): neighbours get the opposite force, and the couple (P_target - c) x F as forces mu x R
// (X_j - C). The force then is -grad of sum k/2 |P - P_target|^2: momentum and angular momentum hold to round-off. Its
// tangent is -k J^T J, J = d(P - P_target)/dx: symmetric, never indefinite, exact where the force vanishes.
// reaction = false: the form of the paper. The force acts on the node alone, so a body that is deformed pulls itself
// through space; the forces come from no energy. tangent = frame is then exact and not symmetric; tangent = target
// holds the targets where they are (-k I), which suits any solver.
//
// Having an energy it has other minima too: a body in complete disorder, or in its mirror image, may settle folded.
// reaction = upright: as true, but a neighbourhood that is turned inside out acts on its node alone. From any shape
// tried the body finds back to its rest shape, as it does with the form of the paper; the laws hold while no
// neighbourhood is inverted. Its tangent is that of the force, and not symmetric where one is.
//
// A node at the mean of its neighbours (the inside of a regular grid) has r = 0: no frame is computed for it, and a
// homogeneous stretch there costs nothing; it is the border of the body that remembers its size. To keep the volume,
// add a VolumeConstraint.
//
// nodes = contour: a node on the surface has neighbours on the surface only (joined by an edge of a face); the nodes
// inside follow their own neighbours.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <RegularGridTopology name="grid" n="4 4 6" min="0 0 0" max="0.1 0.1 0.2"/>
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-8"/>
//   <Node name="body">
//     <TetrahedronSetTopologyContainer name="tets"/>
//     <Hexa2TetraTopologicalMapping input="@../grid" output="@tets" swapping="true"/>
//     <MechanicalObject/>
//     <UniformMass totalMass="2"/>
//     <ShapeMemoryForceField stiffness="2000"/>
//     <BoxROI name="held" box="-1 -1 -0.001 1 1 0.001"/>
//     <FixedProjectiveConstraint indices="@held.indices"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "components/shape_memory/shape_memory.h"
#include "framework/mechanics/force_field.h"
#include "framework/mechanics/state_topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

enum class NodesWord : int { all, contour };
enum class FrameWord : int { best_fit, triangle };
enum class TangentWord : int { frame, target };
enum class ReactionWord : int { yes, no, upright };
class ShapeMemoryForceField final : public ForceField {
 public:
  void declare(DataTable& table) override;
  void init() override;
  ForceTraits traits() const override;
  void compile() override;

  double energy(ConstRows x) const override;
  void addForce(ConstRows x, ConstRows, Rows f) override;
  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override;
  void addPattern(BlockPattern& pattern) const override;
  void addStiffness(double factor, BlockMatrix& matrix) const override;
  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override;
  Cost cost() const override;
  std::string worstElement(ConstRows x) const override;

 private:
  bool hasReaction() const { return reaction_ != ReactionWord::no; }
  /// add(node, block) of a target that does not move: -factor k I.
  template <class Add>
  void forEachTarget(double factor, Add&& add) const {
    for (Index b = 0; b < memory_.batches(); ++b)
      for (int l = 0; l < pack_lanes && memory_.node(b, l) >= 0; ++l)
        add(memory_.node(b, l), Mat3(-factor * memory_.stiffness(b).get(std::size_t(l)) * Mat3::Identity()));
  }
  Adjacency findNeighbours() const;
  Adjacency bestTriangles(const Adjacency& all) const;
  TopologyLink topology_;
  std::vector<double> stiffness_{1};
  NodesWord nodes_ = NodesWord::all;
  FrameWord frame_ = FrameWord::best_fit;
  TangentWord tangent_ = TangentWord::frame;
  ReactionWord reaction_ = ReactionWord::yes;
  double own_weight_ = 0.1;

  const Mesh* mesh_ = nullptr;
  Adjacency lists_;  ///< neighbours of each node of the state
  ShapeMemory memory_;
};

void ShapeMemoryForceField::declare(DataTable& table) {
  ForceField::declare(table);
  topology_.declare(table, "mesh whose edges make neighbours");
  table.add("stiffness", stiffness_)
      .alias("kElas")
      .unit("N/m")
      .min(0, false)
      .physical()
      .help("elastic modulus of the actuator: one value, or one per node");
  table.addChoice("nodes", nodes_, {"all", "contour"})
      .help("contour: nodes of the surface have neighbours on the surface only");
  table.addChoice("frame", frame_, {"bestFit", "triangle"})
      .help("rotation of a neighbourhood: best fit of all neighbours, or of the three that span the largest triangle");
  table.addChoice("reaction", reaction_, {"true", "false", "upright"})
      .help("neighbours get the opposite force and couple: momentum is conserved; upright: unless they are inverted");
  table.addChoice("tangent", tangent_, {"frame", "target"})
      .help("stiffness: targets move with the neighbours, or (without reaction) are fixed");
  table.add("ownWeight", own_weight_)
      .unit("-")
      .min(1e-6)
      .max(1)
      .help("weight of the node itself in the fit of its neighbourhood's rotation; a neighbour has 1");
}

void ShapeMemoryForceField::init() {
  ForceField::init();
  const Topology* topology = topology_.find(*this, state(), MeshNodes::first);
  if (!topology) throw ComponentError("there is no mesh", "a topology with cells in this node or above");
  mesh_ = &topology->mesh();
  if (reaction_ == ReactionWord::upright && frame_ == FrameWord::triangle)
    throw ComponentError("three neighbours lie in a plane: they are never upright nor inverted",
                         "reaction=\"true\" or \"false\", or frame=\"bestFit\"");
  if (hasReaction() && tangent_ == TangentWord::target)
    throw ComponentError("tangent target fixes the targets that reaction moves", "tangent=\"frame\", or reaction=\"false\"");
  const std::size_t count = std::size_t(state().size());
  if (stiffness_.size() != 1 && stiffness_.size() != count)
    throw ComponentError(fmt::format("stiffness has {} values", stiffness_.size()),
                         fmt::format("1, or {} (one per node)", count));
  lists_ = findNeighbours();
  if (lists_.values.empty())
    throw ComponentError(fmt::format("{} has no cells, so no node has neighbours", topology->path()),
                         "a mesh with edges, faces or volume cells");
  const auto alone = [&] {
    Index number = 0;
    for (std::size_t i = 0; i < count; ++i) number += lists_.start[i] == lists_.start[i + 1];
    return number;
  }();
  if (alone > 0) inform(fmt::format("{} nodes of {} belong to no cell: they have no target", alone, state().path()));
}

/// Neighbours by the edges of the cells, one list for each node of the state.
Adjacency ShapeMemoryForceField::findNeighbours() const {
  Adjacency lists = mesh_->nodesAroundNode();
  if (nodes_ == NodesWord::contour) {
    Mesh surface;
    surface.position = mesh_->position;
    const bool has_prisms = !mesh_->prisms.empty() || !mesh_->pyramids.empty();
    surface.triangles = mesh_->tetrahedra.empty() && !has_prisms ? mesh_->triangles : mesh_->boundaryTriangles();
    surface.quads = mesh_->hexahedra.empty() && !has_prisms ? mesh_->quads : mesh_->boundaryQuads();
    if (surface.triangles.empty() && surface.quads.empty())
      throw ComponentError("the mesh has no surface", "volume cells, triangles or quads, or nodes=\"all\"");
    const Adjacency& contour = surface.nodesAroundNode();
    Adjacency mixed;
    for (std::size_t i = 0; i + 1 < lists.start.size(); ++i) {
      const Adjacency& from = contour.start[i] < contour.start[i + 1] ? contour : lists;
      mixed.values.insert(mixed.values.end(), from.values.begin() + from.start[i],
                          from.values.begin() + from.start[i + 1]);
      mixed.start.push_back(Index(mixed.values.size()));
    }
    lists = std::move(mixed);
  }
  lists.start.resize(std::size_t(state().size()) + 1, lists.start.back());
  return frame_ == FrameWord::triangle ? bestTriangles(lists) : lists;
}

/// The three neighbours that span the largest triangle at rest; lists of up to three stay as they are.
Adjacency ShapeMemoryForceField::bestTriangles(const Adjacency& all) const {
  const auto& rest = state().rest_position;
  Adjacency out;
  for (Index i = 0; i < all.size(); ++i) {
    const Index* list = all.values.data() + all.start[i];
    const Index count = all.start[i + 1] - all.start[i];
    std::array<Index, 3> best{0, 1, 2};
    double largest = -1;
    for (Index a = 0; a < count; ++a)
      for (Index b = a + 1; b < count; ++b)
        for (Index c = b + 1; c < count; ++c) {
          const Vec3& p = rest[list[a]];
          const Vec3 u = rest[list[b]] - p, v = rest[list[c]] - p;
          const double area = u.cross(v).squaredNorm();
          if (area > largest * (1 + 1e-9)) largest = area, best = {a, b, c};
        }
    for (Index k = 0; k < std::min(count, Index(3)); ++k) out.values.push_back(list[best[k]]);
    out.start.push_back(Index(out.values.size()));
  }
  return out;
}

ForceTraits ShapeMemoryForceField::traits() const {
  ForceTraits traits;
  traits.has_rest_shape = true;
  traits.conservative = traits.forces_balance = traits.torques_balance = reaction_ == ReactionWord::yes;
  traits.symmetric = reaction_ == ReactionWord::yes || tangent_ == TangentWord::target;
  traits.exact_tangent = !hasReaction() && tangent_ == TangentWord::frame;
  traits.constant_stiffness = tangent_ == TangentWord::target;
  return traits;
}

void ShapeMemoryForceField::compile() {
  memory_.build({lists_, state().rest_position, stiffness_, own_weight_, hasReaction(),
                 reaction_ == ReactionWord::upright, state().firstRow()});
}

// ---- the role of a force field ----

void ShapeMemoryForceField::addForce(ConstRows x, ConstRows, Rows f) {
  memory_.forEachBatch([&](Index b) { memory_.act(b, memory_.drawn(x, b) * memory_.stiffness(b), f); });
  memory_.addReactions(f);
}

void ShapeMemoryForceField::addStiffnessProduct(ConstRows dx, double factor, Rows df) const {
  const Pack scale(factor);
  memory_.forEachBatch([&](Index b) {
    const Pack k = memory_.stiffness(b) * scale;
    if (tangent_ == TangentWord::target)
      addToRows(gatherRows(dx.data, memory_.rows(b)) * -k, memory_.rows(b), df.data);
    else
      memory_.act(b, memory_.drawnChange(dx, b) * k, df);
  });
  memory_.addReactions(df);
}

/// sum k/2 |P - P_target|^2
double ShapeMemoryForceField::energy(ConstRows x) const {
  return memory_.sum([&](Index b) {
    const V3<Pack> d = memory_.drawnOnly(x, b);
    return dot(d, d) * memory_.stiffness(b) * Pack(0.5);
  });
}

/// Measured on one core at 2.6 GHz with 8 lanes, in a mesh of tetrahedra; a block of the matrix is a 3x3 product.
ForceField::Cost ShapeMemoryForceField::cost() const {
  const double n = double(lists_.size()), valence = double(lists_.values.size()) / n;
  const double blocks = n * (hasReaction() ? (valence + 1) * (valence + 1) : valence + 1);
  if (tangent_ == TangentWord::target) return {5 * n, 8 * n};
  const double around = std::min(1., (valence + 2) / 16);  // of the usual neighbours
  return {n * around * (hasReaction() ? 45 : 30) * 8. / pack_lanes, 15 * blocks};
}

std::string ShapeMemoryForceField::worstElement(ConstRows x) const {
  double worst = -1;
  Index at = -1;
  for (Index b = 0; b < memory_.batches(); ++b) {
    const V3<Pack> d = memory_.drawnOnly(x, b);
    alignas(64) double squared[pack_lanes];
    dot(d, d).store_aligned(squared);
    for (int l = 0; l < pack_lanes; ++l) {
      const Index node = memory_.node(b, l);
      if (node >= 0 && worst == worst && !(squared[l] <= worst)) worst = squared[l], at = node;  // a NaN is the worst
      if (worst != worst) break;
    }
  }
  return fmt::format("node {}: {:.3g} m from its target", at, std::sqrt(worst));
}

// ---- the matrix ----

void ShapeMemoryForceField::addPattern(BlockPattern& pattern) const {
  for (Index i = 0; i < lists_.size() && tangent_ == TangentWord::frame; ++i) {
    std::vector<Index> rows{i + state().firstRow()};
    for (Index k = lists_.start[i]; k < lists_.start[i + 1]; ++k) rows.push_back(lists_.values[k] + state().firstRow());
    if (hasReaction())
      pattern.addClique(rows.data(), int(rows.size()));
    else
      for (const Index column : rows) pattern.addBlock(rows[0], column);
  }
}

void ShapeMemoryForceField::addStiffness(double factor, BlockMatrix& matrix) const {
  const Index first = state().firstRow();
  if (tangent_ == TangentWord::target)
    return forEachTarget(factor, [&](Index node, const Mat3& block) { matrix.add(first + node, first + node, block); });
  memory_.forEachJacobian(lists_,
                          [&](const std::vector<Index>& nodes, const std::vector<Mat3>& j, double k, bool passes) {
                            const double s = -factor * k;
                            const Index row = first + nodes[0];
                            for (std::size_t b = 0; b < nodes.size(); ++b) {
                              if (!hasReaction() || !passes) matrix.add(row, first + nodes[b], Mat3(s * j[b]));
                              for (std::size_t a = 0; a < nodes.size() && hasReaction() && passes; ++a)
                                matrix.add(first + nodes[a], first + nodes[b], Mat3(s * j[a].transpose() * j[b]));
                            }
                          });
}

void ShapeMemoryForceField::addStiffnessDiagonal(double factor, std::vector<double>& diagonal) const {
  const auto add = [&](Index node, const Mat3& block) {
    double* out = diagonal.data() + std::size_t(state().firstRow() + node) * 9;
    for (int i = 0; i < 9; ++i) out[i] += block(i / 3, i % 3);
  };
  if (tangent_ == TangentWord::target) return forEachTarget(factor, add);
  memory_.forEachJacobian(lists_,
                          [&](const std::vector<Index>& nodes, const std::vector<Mat3>& j, double k, bool passes) {
                            const double s = -factor * k;
                            if (!hasReaction() || !passes) return add(nodes[0], s * j[0]);
                            for (std::size_t a = 0; a < nodes.size(); ++a) add(nodes[a], s * j[a].transpose() * j[a]);
                          });
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(shape_memory_force_field) {
  using stroma::ShapeMemoryForceField;
  const char* help = "Phymul: each node is drawn to the place that its neighbours remember for it";
  factory.add<ShapeMemoryForceField>("ShapeMemoryForceField", help);
  factory.add<ShapeMemoryForceField>("Phymul", help);
}
