// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/free_body.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace stroma {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

/// Which rows hang together; every row starts alone.
class Connections {
 public:
  explicit Connections(Index rows) : parent_(std::size_t(rows)) { std::iota(parent_.begin(), parent_.end(), 0); }
  Index find(Index row) {
    while (parent_[row] != row) row = parent_[row] = parent_[parent_[row]];
    return row;
  }
  void join(Index a, Index b) { parent_[find(b)] = find(a); }

 private:
  std::vector<Index> parent_;
};

/// A connected part: what it is and what its rigid motions feel. Motions 0 to 2 are shifts, 3 to 5 turns about the axes
/// through the centre, scaled to the mean distance from it.
struct Body {
  Index first_row = -1, rows = 0, places = 0;
  Vec3 centre = Vec3::Zero();
  double radius = 0;               ///< root mean square distance from the centre [m]
  double diagonal = 0, loads = 0;  ///< sums of the sizes of the matrix's diagonal [N/m] and of the forces [N]
  Mat6 stiffness = Mat6::Zero();
  Vec6 load = Vec6::Zero();
};

std::vector<Index> bodyOfRow(const System& system) {
  BlockPattern pattern(system.allRows());
  for (ForceField* field : system.forceFields())
    if (field->traits().has_stiffness) field->addPattern(pattern);
  Connections connections(system.allRows());
  for (Index row = 0; row < pattern.rows(); ++row)
    for (Index column : pattern.columns(row)) connections.join(row, column);
  // a mapped state and the one it follows are taken as one body
  for (const Mapping* mapping : system.actors().mappings)
    for (const State* state : {&mapping->input(), &mapping->output()})
      for (Index i = 0; i < state->size(); ++i) connections.join(mapping->input().firstRow(), state->firstRow() + i);
  const LinearRelations& relations = system.constraints().relations().relations();
  for (Index relation = 0; relation < relations.count(); ++relation)
    for (auto term = relations.begin(relation); term != relations.end(relation); ++term)
      connections.join(relations.begin(relation)->row, term->row);
  std::vector<Index> body(std::size_t(system.independentRows())), number(std::size_t(system.allRows()), -1);
  Index count = 0;
  for (Index row = 0; row < system.independentRows(); ++row) {
    Index& id = number[connections.find(row)];
    if (id < 0) id = count++;
    body[row] = id;
  }
  return body;
}

/// What motion `number` does to a row: an orientation turns with its body and has no shift, a number does not take part.
Vec3 motion(const System& system, const Body& body, int number, Index row) {
  const RowKind kind = system.motion().kindOf(row);
  if (kind == RowKind::value) return Vec3::Zero();
  if (number < 3) return kind == RowKind::place ? Vec3(Vec3::Unit(number)) : Vec3(Vec3::Zero());
  if (body.radius == 0) return Vec3::Zero();
  const Vec3 axis = Vec3::Unit(number - 3);
  return (kind == RowKind::turn ? axis : Vec3(axis.cross(system.x[row] - body.centre))) / body.radius;
}

std::vector<Body> measure(const System& system, const std::vector<Index>& body_of_row,
                          const std::vector<double>& blocks, ConstRows force) {
  std::vector<Body> bodies;
  const auto of = [&](Index row) -> Body& { return bodies[body_of_row[row]]; };
  const Index rows = Index(body_of_row.size());
  for (Index row = 0; row < rows; ++row) {
    if (std::size_t(body_of_row[row]) == bodies.size()) bodies.push_back({.first_row = row});
    Body& body = of(row);
    ++body.rows;
    if (system.motion().kindOf(row) == RowKind::place) body.centre += (system.x[row] - body.centre) / ++body.places;
    body.loads += force[row].norm();
    for (int c = 0; c < 3; ++c) body.diagonal += std::abs(blocks[9 * std::size_t(row) + 4 * std::size_t(c)]);
  }
  for (Index row = 0; row < rows; ++row)
    if (system.motion().kindOf(row) == RowKind::place) of(row).radius += (system.x[row] - of(row).centre).squaredNorm();
  for (Body& body : bodies) body.radius = std::sqrt(body.radius / std::max<Index>(1, body.places));
  return bodies;
}

/// T^T A T and T^T f of every body. Directions that constraints hold resist with what a row resists.
void feel(System& system, SystemMatrix& matrix, const std::vector<Index>& body_of_row, ConstRows force,
          std::vector<Body>& bodies) {
  const Index rows = Index(body_of_row.size());
  Vector mode[6], product[6];
  const auto of = [&](Index row) -> Body& { return bodies[body_of_row[row]]; };
  for (int m = 0; m < 6; ++m) {
    mode[m].resize(rows), product[m].resize(rows);
    for (Index row = 0; row < rows; ++row) mode[m][row] = motion(system, of(row), m, row);
    system.constraints().project(mode[m]);
    matrix.multiply(mode[m], product[m]);
  }
  for (Index row = 0; row < rows; ++row) {
    Body& body = of(row);
    const double resistance = body.diagonal / (3 * body.rows);
    for (int m = 0; m < 6; ++m) {
      const Vec3 held = motion(system, body, m, row) - mode[m][row];
      body.load[m] += force[row].dot(mode[m][row]);
      for (int n = 0; n < 6; ++n)
        body.stiffness(m, n) +=
            mode[m][row].dot(product[n][row]) + resistance * held.dot(motion(system, body, n, row) - mode[n][row]);
    }
  }
}

std::string nameOf(const System& system, const Body& body) {
  for (const State* state : system.states()) {
    const Index local = body.first_row - state->firstRow();
    if (local < 0 || local >= state->size()) continue;
    if (body.rows >= state->size()) return state->path();
    return body.rows == 1 ? fmt::format("node {} of {}, which no force ties to another,", local, state->path())
                          : fmt::format("the part of {} around node {} ({} nodes)", state->path(), local, body.rows);
  }
  return "a body";
}

/// The part of the load that motions without resistance work on.
Vec6 unresisted(const Body& body) {
  const Eigen::SelfAdjointEigenSolver<Mat6> modes(0.5 * (body.stiffness + body.stiffness.transpose()));
  Vec6 load = Vec6::Zero();
  for (int m = 0; m < 6; ++m)
    if (std::abs(modes.eigenvalues()[m]) <= 1e-11 * body.diagonal)
      load += modes.eigenvectors().col(m) * modes.eigenvectors().col(m).dot(body.load);
  return load;
}

std::string sentence(const System& system, const Body& body, const Vec6& load) {
  const Vec3 shift = load.head<3>(), turn = load.tail<3>() * body.radius;
  if (shift.norm() >= load.tail<3>().norm()) {
    const Vec3 direction = shift.normalized();
    return fmt::format(
        "{} is not held in the direction ({:.3g} {:.3g} {:.3g}) and the forces on it there sum to {:.3g} N: "
        "it has no equilibrium. Hold some of its nodes (FixedProjectiveConstraint)",
        nameOf(system, body), direction[0], direction[1], direction[2], shift.norm());
  }
  const Vec3 axis = turn.normalized();
  return fmt::format(
      "{} is not held against turning about the axis ({:.3g} {:.3g} {:.3g}) through ({:.3g} {:.3g} {:.3g}) and the "
      "forces on it have a torque of {:.3g} N m there: it has no equilibrium. Hold more of its nodes "
      "(FixedProjectiveConstraint)",
      nameOf(system, body), axis[0], axis[1], axis[2], body.centre[0], body.centre[1], body.centre[2], turn.norm());
}

}  // namespace

std::string freeBody(System& system, ConstRows force) {
  SystemMatrix& matrix = system.matrix().withFactors({.stiffness = -1});
  std::vector<double> blocks;
  matrix.diagonalBlocks(blocks);
  const std::vector<Index> body_of_row = bodyOfRow(system);
  std::vector<Body> bodies = measure(system, body_of_row, blocks, force);
  feel(system, matrix, body_of_row, force, bodies);
  for (const Body& body : bodies) {
    const Vec6 load = unresisted(body);
    if (load.norm() > 1e-9 * body.loads) return sentence(system, body, load);
  }
  return {};
}

}  // namespace stroma
