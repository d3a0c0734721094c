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

/// A part that forces hold together: what it is and what its rigid motions feel. Motions 0 to 2 are shifts, 3 to 5 turns
/// about the axes through the centre, scaled to the mean distance from it.
struct RigidPart {
  Index first_row = -1, rows = 0, places = 0;
  Vec3 centre = Vec3::Zero();
  double radius = 0;               ///< root mean square distance from the centre [m]
  double diagonal = 0, loads = 0;  ///< sums of the sizes of the matrix's diagonal [N/m] and of the forces [N]
  double unit() const { return diagonal > 0 ? std::sqrt(diagonal) : 1; }
};

/// Parts that constraints tie to each other: what their rigid motions feel together.
struct Cluster {
  std::vector<Index> parts;
  Eigen::MatrixXd stiffness;  ///< shape (6 parts, 6 parts), each motion over the unit() of its part
  Eigen::VectorXd load;       ///< the same for the forces
};

struct Division {
  std::vector<Index> part_of_row;     ///< shape (independent rows)
  std::vector<Index> number_of_part;  ///< in its cluster
  std::vector<Index> cluster_of_part;
  std::size_t clusters = 0;
};

/// Every part of a cluster has motions of its own as long as there are not more than this: each takes six vectors.
constexpr Index most_parts = 8;

/// Whether the matrix of the system has been laid out, and couples what stiffness couples and nothing else.
bool hasPatternOfStiffness(System& system) {
  const Actors& actors = system.actors();
  const auto is_stiff = [](const ForceField* field) { return field->traits().has_stiffness; };
  return system.matrix().keptBlocks() >= 0 && actors.mappings.empty() && actors.massIsDiagonal() &&
         system.constraints().mixedRows().empty() && std::ranges::all_of(actors.damped_fields, is_stiff);
}

/// What stiffness and mappings hold together.
Connections connectedRows(System& system) {
  if (hasPatternOfStiffness(system)) {
    const BlockMatrix& matrix = system.matrix().pattern();
    Connections connections(matrix.rows());
    for (Index row = 0; row < matrix.rows(); ++row)
      for (Index s = matrix.rowStart()[row]; s < matrix.rowStart()[row + 1]; ++s) connections.join(row, matrix.columns()[s]);
    return connections;
  }
  BlockPattern pattern(system.allRows());
  for (ForceField* field : system.forceFields())
    if (field->traits().has_stiffness) field->addPattern(pattern);
  Connections connections(system.allRows());
  for (Index row = 0; row < pattern.rows(); ++row)
    for (Index column : pattern.columns(row)) connections.join(row, column);
  // a mapped state and the one it follows are taken as one part
  for (const Mapping* mapping : system.actors().mappings)
    for (const State* parent : mapping->inputs())
      for (const State* state : statesActedOn(*mapping))
        for (Index i = 0; i < state->size(); ++i) connections.join(parent->firstRow(), state->firstRow() + i);
  return connections;
}

/// Calls visit(a, b) for rows that ties and relations join.
template <class Visit>
void forEachTie(const System& system, const Visit& visit) {
  const NodeGroups& groups = system.constraints().groups();
  const LinearRelations& relations = system.constraints().relations().relations();
  for (Index row = 0; row < system.independentRows(); ++row)
    if (const Index group = groups.of(row); group >= 0) visit(*groups.begin(group), row);
  for (Index relation = 0; relation < relations.count(); ++relation)
    for (auto term = relations.begin(relation); term != relations.end(relation); ++term)
      visit(relations.begin(relation)->row, term->row);
}

/// Numbers from 0 for what find() returns, in the order of rows.
std::vector<Index> numbered(Connections& connections, const System& system) {
  std::vector<Index> number_of(std::size_t(system.allRows()), -1), numbers(std::size_t(system.independentRows()));
  Index count = 0;
  for (Index row = 0; row < system.independentRows(); ++row) {
    Index& number = number_of[connections.find(row)];
    if (number < 0) number = count++;
    numbers[row] = number;
  }
  return numbers;
}

Division divide(System& system) {
  Connections parts = connectedRows(system), clusters = parts;
  forEachTie(system, [&clusters](Index a, Index b) { clusters.join(a, b); });
  const auto count = [&](const std::vector<Index>& part_of_row, const std::vector<Index>& cluster_of_row) {
    Division division;
    division.part_of_row = part_of_row;
    std::vector<Index> sizes;
    for (std::size_t row = 0; row < part_of_row.size(); ++row) {
      if (std::size_t(part_of_row[row]) < division.cluster_of_part.size()) continue;  // seen before
      const Index cluster = cluster_of_row[row];
      sizes.resize(std::max(sizes.size(), std::size_t(cluster) + 1));
      division.cluster_of_part.push_back(cluster);
      division.number_of_part.push_back(sizes[cluster]++);
    }
    division.clusters = sizes.size();
    return division;
  };
  const std::vector<Index> cluster_of_row = numbered(clusters, system);
  const Division fine = count(numbered(parts, system), cluster_of_row);
  std::vector<char> is_many(fine.clusters, 0);
  for (std::size_t part = 0; part < fine.cluster_of_part.size(); ++part)
    if (fine.number_of_part[part] >= most_parts) is_many[fine.cluster_of_part[part]] = 1;
  forEachTie(system, [&](Index a, Index b) {
    if (is_many[cluster_of_row[a]]) parts.join(a, b);
  });
  return count(numbered(parts, system), cluster_of_row);
}

/// What motion `number` does to a row: an orientation turns with its body and has no shift, a number does not take part.
Vec3 motion(const System& system, const RigidPart& part, int number, Index row) {
  const RowKind kind = system.motion().kindOf(row);
  if (kind == RowKind::value) return Vec3::Zero();
  if (number < 3) return kind == RowKind::place ? Vec3(Vec3::Unit(number)) : Vec3(Vec3::Zero());
  if (part.radius == 0) return Vec3::Zero();
  const Vec3 axis = Vec3::Unit(number - 3);
  return (kind == RowKind::turn ? axis : Vec3(axis.cross(system.x[row] - part.centre))) / part.radius;
}

/// Torques count as forces at the radius, whatever the unit of length; turns of what has none are not looked at.
double shareOf(const System& system, const RigidPart& part, Index row) {
  if (system.motion().kindOf(row) != RowKind::turn) return 1;
  return part.radius > 0 ? 1 / part.radius : 0;
}

std::vector<RigidPart> measure(const System& system, const std::vector<Index>& part_of_row,
                               const std::vector<double>& blocks, ConstRows force) {
  std::vector<RigidPart> parts;
  const auto of = [&](Index row) -> RigidPart& { return parts[part_of_row[row]]; };
  const Index rows = Index(part_of_row.size());
  for (Index row = 0; row < rows; ++row) {
    if (std::size_t(part_of_row[row]) == parts.size()) parts.push_back({.first_row = row});
    RigidPart& part = of(row);
    ++part.rows;
    if (system.motion().kindOf(row) == RowKind::place) part.centre += (system.x[row] - part.centre) / ++part.places;
  }
  for (Index row = 0; row < rows; ++row)
    if (system.motion().kindOf(row) == RowKind::place) of(row).radius += (system.x[row] - of(row).centre).squaredNorm();
  for (RigidPart& part : parts) part.radius = std::sqrt(part.radius / std::max<Index>(1, part.places));
  for (Index row = 0; row < rows; ++row) {
    RigidPart& part = of(row);
    const double share = shareOf(system, part, row);
    part.loads += share * force[row].norm();
    for (int c = 0; c < 3; ++c) part.diagonal += share * share * std::abs(blocks[9 * std::size_t(row) + 4 * std::size_t(c)]);
  }
  return parts;
}

/// Whether every part has three fixed nodes that are not in a line: none can be shifted or turned.
bool areAllFixed(const System& system, const std::vector<Index>& part_of_row) {
  struct Fixed {
    Index nodes = 0;
    Vec3 first = Vec3::Zero(), line = Vec3::Zero();  ///< a node, and from there the longest way to another
    double area = 0;                                  ///< twice the largest triangle on that line
  };
  std::vector<Fixed> parts;
  for (const Index part : part_of_row) parts.resize(std::max(parts.size(), std::size_t(part) + 1));
  for (const bool again : {false, true})
    for (const NodeProjector& held : system.constraints().projectors()) {
      if (!held.projector.isZero(0) || system.motion().kindOf(held.row) != RowKind::place) continue;
      Fixed& part = parts[std::size_t(part_of_row[std::size_t(held.row)])];
      if (part.nodes++ == 0) part.first = system.x[held.row];
      const Vec3 way = system.x[held.row] - part.first;
      if (!again && way.squaredNorm() > part.line.squaredNorm()) part.line = way;
      if (again) part.area = std::max(part.area, way.cross(part.line).norm());
    }
  return std::ranges::all_of(parts, [](const Fixed& part) { return part.area > 1e-6 * part.line.squaredNorm(); });
}

/// T^T A T and T^T f of every cluster. Directions that constraints hold resist with what a row resists: a motion that the
/// constraints allow is one that they leave as it is.
std::vector<Cluster> feel(System& system, SystemMatrix& matrix, const Division& division, ConstRows force,
                          const std::vector<RigidPart>& parts) {
  std::vector<Cluster> clusters(division.clusters);
  for (std::size_t part = 0; part < parts.size(); ++part)
    clusters[division.cluster_of_part[part]].parts.push_back(Index(part));
  std::size_t most = 0;
  for (Cluster& cluster : clusters) {
    const auto motions = Eigen::Index(6 * cluster.parts.size());
    cluster.stiffness.setZero(motions, motions), cluster.load.setZero(motions);
    most = std::max(most, cluster.parts.size());
  }
  const Index rows = Index(division.part_of_row.size());
  // motion m of a cluster is motion m % 6 of its part m / 6
  const auto given = [&](Index m, Index row) -> Vec3 {
    const Index part = division.part_of_row[row];
    if (division.number_of_part[part] != m / 6) return Vec3::Zero();
    return motion(system, parts[part], int(m % 6), row) / parts[part].unit();
  };
  std::vector<Vector> modes(6 * most);
  Vector product(rows);
  for (Index m = 0; m < Index(modes.size()); ++m) {
    modes[m].resize(rows);
    for (Index row = 0; row < rows; ++row) modes[m][row] = given(m, row);
    system.constraints().project(modes[m]);
  }
  for (Index n = 0; n < Index(modes.size()); ++n) {
    matrix.multiply(modes[n], product);
    for (Index row = 0; row < rows; ++row) {
      const RigidPart& part = parts[division.part_of_row[row]];
      Cluster& cluster = clusters[division.cluster_of_part[division.part_of_row[row]]];
      if (n >= cluster.load.size()) continue;
      const double share = shareOf(system, part, row);
      const double resistance = (part.diagonal > 0 ? part.diagonal / (3 * part.rows) : 1) / (share > 0 ? share * share : 1);
      const Vec3 held = given(n, row) - modes[n][row];
      const bool is_held = (held.array() != 0).any();
      cluster.load[n] += force[row].dot(modes[n][row]);
      for (Index m = 0; m < cluster.load.size(); ++m)
        cluster.stiffness(m, n) += modes[m][row].dot(product[row]) +
                                   (is_held ? resistance * held.dot(given(m, row) - modes[m][row]) : 0.0);
    }
  }
  return clusters;
}

std::string nameOf(const System& system, const RigidPart& part) {
  for (const State* state : system.states()) {
    const Index local = part.first_row - state->firstRow();
    if (local < 0 || local >= state->size()) continue;
    if (part.rows >= state->size()) return state->path();
    return part.rows == 1 ? fmt::format("node {} of {}, which no force ties to another,", local, state->path())
                          : fmt::format("the part of {} around node {} ({} nodes)", state->path(), local, part.rows);
  }
  return "a body";
}

/// The part of the load that motions without resistance work on, on each part of a cluster: six forces and torques.
std::vector<Vec6> unresisted(const Cluster& cluster, const std::vector<RigidPart>& parts) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(0.5 * (cluster.stiffness + cluster.stiffness.transpose()));
  Eigen::VectorXd load = Eigen::VectorXd::Zero(cluster.load.size());
  for (Eigen::Index m = 0; m < load.size(); ++m)
    if (std::abs(modes.eigenvalues()[m]) <= 1e-11)
      load += modes.eigenvectors().col(m) * modes.eigenvectors().col(m).dot(cluster.load);
  std::vector<Vec6> of_part(cluster.parts.size());
  for (std::size_t k = 0; k < of_part.size(); ++k)
    of_part[k] = load.segment<6>(Eigen::Index(6 * k)) * parts[cluster.parts[k]].unit();
  return of_part;
}

/// Without components that are round-off beside this size.
Vec3 rounded(const Vec3& vector, double size) { return (vector.array().abs() < 1e-9 * size).select(0., vector); }
Vec3 directionOf(const Vec3& vector) { return rounded(vector.normalized(), 1); }

std::string shiftSentence(const std::string& name, const Vec3& shift) {
  const Vec3 direction = directionOf(shift);
  return fmt::format(
      "{} is not held in the direction ({:.3g} {:.3g} {:.3g}) and the forces on it there sum to {:.3g} N: it has no equilibrium. "
      "Fix some of its nodes (FixedProjectiveConstraint)",
      name, direction[0], direction[1], direction[2], shift.norm());
}

std::string turnSentence(const std::string& name, const Vec3& about, const Vec3& point, double torque) {
  const Vec3 axis = directionOf(about);
  return fmt::format(
      "{} is not held against rotation about the axis ({:.3g} {:.3g} {:.3g}) through ({:.3g} {:.3g} {:.3g}) and the forces on it "
      "have a torque of {:.3g} N m there: it has no equilibrium. Fix more of its nodes (FixedProjectiveConstraint)",
      name, axis[0], axis[1], axis[2], point[0], point[1], point[2], torque);
}

/// The part of the sum of all forces along which a cluster can be shifted as a whole.
Vec3 unresistedShift(const Cluster& cluster, const std::vector<RigidPart>& parts) {
  Eigen::MatrixXd together = Eigen::MatrixXd::Zero(cluster.load.size(), 3);
  for (std::size_t k = 0; k < cluster.parts.size(); ++k)
    together.block<3, 3>(Eigen::Index(6 * k), 0) = parts[cluster.parts[k]].unit() * Mat3::Identity();
  const Eigen::SelfAdjointEigenSolver<Mat3> modes(together.transpose() * cluster.stiffness * together);
  const Vec3 force = together.transpose() * cluster.load;
  Vec3 free = Vec3::Zero();
  for (int c = 0; c < 3; ++c)
    if (std::abs(modes.eigenvalues()[c]) <= 1e-11 * together.col(0).squaredNorm())
      free += modes.eigenvectors().col(c) * modes.eigenvectors().col(c).dot(force);
  return free;
}

/// `loads`: of each part, see unresisted(). The part that is pushed most stands for the cluster.
std::string sentence(const System& system, const std::vector<RigidPart>& parts, const Cluster& cluster,
                     const std::vector<Vec6>& loads) {
  const auto largest =
      std::max_element(loads.begin(), loads.end(), [](const Vec6& a, const Vec6& b) { return a.norm() < b.norm(); });
  const double most = largest->norm();
  const RigidPart& part = parts[cluster.parts[std::size_t(largest - loads.begin())]];
  const Vec3 push = largest->head<3>(), torque = largest->tail<3>() * part.radius;
  std::string name = nameOf(system, part);
  const Vec3 shift = unresistedShift(cluster, parts);
  const bool can_shift = shift.norm() > 1e-3 * most;
  if (cluster.parts.size() == 1 && can_shift)
    return push.norm() >= largest->tail<3>().norm()
               ? shiftSentence(name, push)
               : turnSentence(name, torque, part.centre, torque.norm());
  const auto moving =
      std::count_if(loads.begin(), loads.end(), [most](const Vec6& load) { return load.norm() > 1e-6 * most; });
  if (moving > 1) name += " with what is tied to it";
  if (can_shift) return shiftSentence(name, shift);
  if (largest->tail<3>().norm() < 1e-6 * most) return shiftSentence(name, push);
  // it turns about where its motion is nothing: a node that is held, or a point that ties leave it
  const Vec3 spin = largest->tail<3>() / part.radius, axis = spin.normalized();
  const Vec3 point = part.centre + spin.cross(push) / spin.squaredNorm();
  return turnSentence(name, axis, rounded(point, part.radius), axis.dot(torque + (part.centre - point).cross(push)));
}

}  // namespace

std::string freeBody(System& system, ConstRows force) {
  const Division division = divide(system);
  if (areAllFixed(system, division.part_of_row)) return {};
  SystemMatrix& matrix = system.matrix().withFactors({.stiffness = -1});
  std::vector<double> blocks;
  matrix.diagonalBlocks(blocks);
  const std::vector<RigidPart> parts = measure(system, division.part_of_row, blocks, force);
  for (const Cluster& cluster : feel(system, matrix, division, force, parts)) {
    const std::vector<Vec6> loads = unresisted(cluster, parts);
    double pushed = 0, all = 0;
    for (const Vec6& load : loads) pushed += load.squaredNorm();
    for (const Index part : cluster.parts) all += parts[part].loads;
    if (std::sqrt(pushed) > 1e-9 * all) return sentence(system, parts, cluster, loads);
  }
  return {};
}

}  // namespace stroma
