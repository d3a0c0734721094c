// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/multigrid_hierarchy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "components/iterative_solvers/multigrid_galerkin.h"
#include "components/iterative_solvers/multigrid_patch_build.h"
#include "components/iterative_solvers/multigrid_products.h"

namespace stroma::amg {
namespace {

/// Nodes of a level that is small enough to be factored, whatever that takes.
constexpr Index few_nodes = 100;
/// Operations for each block of the first level that factors of a level may take: less than a fifth of what a hierarchy
/// costs. With patches, which cost more and leave more iterations, three times as many.
constexpr double few_operations = 1000;
/// More are not looked at.
constexpr Index most_nodes = 20000;
/// A level with more nodes than this share of the one before is not worth having.
constexpr double least_coarsening = 0.6;
/// See strongLinks(); half of it from level to level.
constexpr double weak_link = 0.08;

BlockView<3> viewOf(const BlockMatrix& a) {
  return {a.rows(), a.rowStart().data(), a.columns().data(), a.diagonal().data(), a.values().data()};
}

/// The directions in which a node is coupled to others: a held direction is in no motion.
Mat3 coupledDirections(const BlockView<3>& a, Index row) {
  Mat3 sum = Mat3::Zero();
  for (Index s = a.start[row]; s < a.start[row + 1]; ++s)
    if (a.columns[s] != row) sum.noalias() += a.block(s) * a.block(s).transpose();
  const double trace = sum.trace();
  if (!(trace > 0)) return Mat3::Zero();
  sum /= trace;
  if (sum.determinant() > 1e-8) return Mat3::Identity();
  const Eigen::SelfAdjointEigenSolver<Mat3> values(sum);
  Mat3 kept = Mat3::Zero();
  for (int k = 0; k < 3; ++k)
    if (values.eigenvalues()[k] > 1e-14)
      kept += values.eigenvectors().col(k) * values.eigenvectors().col(k).transpose();
  return kept;
}

/// Translations, and rotations about the middle in units of the body's size. Returns the rows that are held.
std::vector<Index> rigidMotions(const BlockView<3>& a, ConstRows x, Motions<3>& motions) {
  motions.resize(std::size_t(a.rows));
  const bool known = x.count == a.rows;
  Vec3 middle = Vec3::Zero();
  double size = 0;
  if (known) {
    for (Index i = 0; i < a.rows; ++i) middle += x[i] / double(a.rows);
    for (Index i = 0; i < a.rows; ++i) size = std::max(size, (x[i] - middle).norm());
  }
  std::vector<char> is_held(std::size_t(a.rows), 0);
  forRows(a.rows, [&](Index i) {
    const Mat3 free = coupledDirections(a, i);
    is_held[std::size_t(i)] = free != Mat3::Identity();
    auto block = motions.at(i);
    block.leftCols<3>() = free;
    if (!(size > 0)) return;
    const Vec3 arm = (x[i] - middle) / size;
    for (int k = 0; k < 3; ++k) block.col(3 + k) = free * Vec3(Vec3::Unit(k)).cross(arm);
  });
  std::vector<Index> held;
  for (Index i = 0; i < a.rows; ++i)
    if (is_held[std::size_t(i)]) held.push_back(i);
  return held;
}

/// Makes the levels one after the other.
class Builder {
 public:
  Builder(Hierarchy& made, SolveReport& report, StopToken stop) : made_(made), report_(report), stop_(stop) {}

  /// `level` and all below it. False: the report says why.
  template <int D>
  bool build(const BlockView<D>& a, const Motions<D>& motions, Level<D>& level, double weak) {
    if (stop_.isStopAsked()) return fail(SolveStop::stopped);
    if (const Index bad = fillLevel(a, made_.scale, level); bad >= 0)
      return fail(SolveStop::not_definite, D == 3 ? bad : -1);
    if (isLast(a)) return finish(a);
    const double largest = level.largest = largestEigenvalue(level);
    if (!(largest > 0)) return fail(SolveStop::not_definite);
    if (has_patches_ || D == 3) has_patches_ = addPatches(a, made_.scale, has_patches_, level);
    if (level.patches.exist()) level.largest = largestEigenvalue(level);
    if (!(level.largest > 0)) return fail(SolveStop::not_definite);
    const Aggregates groups = aggregate(strongLinks(a, weak));
    if (groups.count() == 0) return true;
    if (groups.count() > least_coarsening * a.rows) return a.rows > 4 * few_nodes || finish(a);
    Motions<modes> coarse_motions;
    CoarseMatrix coarse;
    makeCoarse(a, groups, motions, largest, level, coarse_motions, coarse);
    made_.coarse.emplace_back();
    return build(coarse.view(), coarse_motions, made_.coarse.back(), weak / 2);
  }

 private:
  template <int D>
  void makeCoarse(const BlockView<D>& a, const Aggregates& groups, const Motions<D>& motions, double largest,
                  Level<D>& level, Motions<modes>& coarse_motions, CoarseMatrix& coarse) {
    Motions<D> basis;
    orthonormalise(groups, motions, basis, coarse_motions);
    smoothBasis(a, groups, basis, made_.scale, largest, level);
    transposeProlongation(level, groups.count());
    coarse = galerkin(a, level);
  }
  /// Whether factors of the level cost little. The step from a level of some hundred nodes to the next is the worst of a
  /// slender body with stiff parts, where groups that move like rigid bodies hardly bend.
  template <int D>
  bool isLast(const BlockView<D>& a) {
    if (a.rows <= few_nodes) return true;
    const double enough = (has_patches_ ? 3 : 1) * few_operations * double(made_.fine.a.blocks());
    return D == modes && a.rows <= most_nodes && LastLevel().layOut(a) <= enough;
  }
  template <int D>
  bool finish(const BlockView<D>& a) {
    made_.last.layOut(a);
    return made_.last.factor(a, made_.scale) || fail(SolveStop::not_definite);
  }
  bool fail(SolveStop stop, Index row = -1) {
    report_.stop = stop;
    report_.row = row;
    return false;
  }

  Hierarchy& made_;
  SolveReport& report_;
  StopToken stop_;
  bool has_patches_ = false;  ///< of the level above
};

/// The largest number of the diagonal; not finite where one of the diagonal is not.
double largestOnDiagonal(const BlockMatrix& a) {
  double largest = 0, sum = 0;
  for (const Index slot : a.diagonal())
    for (const int k : {0, 4, 8}) {
      const double value = a.values()[std::size_t(slot) * 9 + std::size_t(k)];
      largest = std::max(largest, value);
      sum += value;
    }
  return std::isfinite(sum) ? largest : sum;
}

/// Numbers of four bytes as they are, two in the room of a double.
template <class Values>
void serializePairs(Archive& archive, const std::string& name, Values& values) {
  std::int64_t count = std::int64_t(values.size());
  archive.value(name + "_count", count);
  values.resize(std::size_t(count));
  archive.rows(name, reinterpret_cast<double*>(values.data()), std::size_t(count / 2));
  if (count % 2 == 0) return;
  std::int32_t bits = 0;
  std::memcpy(&bits, &values.back(), sizeof bits);
  archive.value(name + "_last", bits);
  std::memcpy(&values.back(), &bits, sizeof bits);
}

template <int R, int C>
void serializeBlocks(Archive& archive, const std::string& name, Blocks<R, C>& blocks) {
  serializePairs(archive, name + "_start", blocks.start);
  serializePairs(archive, name + "_columns", blocks.columns);
  serializePairs(archive, name, blocks.values);
}

template <int D>
void serializePatches(Archive& archive, const std::string& name, Patches<D>& patches) {
  serializePairs(archive, name + "_start", patches.start);
  serializePairs(archive, name + "_members", patches.members);
  archive.list(name + "_entry_start", patches.entry_start);
  serializePairs(archive, name + "_entries", patches.entries);
  archive.list(name + "_first", patches.first);
  archive.list(name + "_place", patches.place);
  serializePairs(archive, name + "_inverses", patches.inverses);
}

template <int D>
void serializeLevel(Archive& archive, const std::string& name, Level<D>& level) {
  serializeBlocks(archive, name + "a", level.a);
  serializeBlocks(archive, name + "p", level.p);
  Index groups = level.r.rows();
  archive.value(name + "groups", groups);
  serializePairs(archive, name + "inverse", level.inverse);
  serializePatches(archive, name + "patches", level.patches);
  archive.value(name + "largest", level.largest);
  if (!archive.isReading()) return;
  if (groups > 0) transposeProlongation(level, groups);
  level.allocateWork();
}

template <int D>
std::size_t bytesOf(const Level<D>& level) {
  const std::size_t floats = level.a.values.size() + level.p.values.size() + level.r.values.size() +
                             level.inverse.size() + 4 * level.x.size() + level.patches.inverses.size() +
                             level.patches.results.size();
  return 4 * (floats + level.a.columns.size() + level.p.columns.size() + level.r.columns.size());
}

}  // namespace

template <int D>
void Hierarchy::cycle(Level<D>& level, std::size_t below) {
  if (below == coarse.size()) {
    if (last.exists()) return last.solve<D>(level.b.data(), level.x.data());
    level.smoothFromZero(4 * smoother_steps);
    return;
  }
  level.smoothFromZero(smoother_steps);
  level.residual();
  Level<modes>& next = coarse[below];
  level.restrictTo(next.b);
  cycle(next, below + 1);
  level.correctBy(next.x);
  level.smooth(smoother_steps);
}

void Hierarchy::apply(ConstRows r, Rows z, const Vector* turns, ProductLevel* products) {
  std::array<double, 32> part{};
  forPieces(r.count, piecesOf(r.count), [&](int k, Index first, Index end) {
    part[std::size_t(k)] = largest(r.segment(first, end - first));
  });
  const double size = std::max(*std::ranges::max_element(part), std::numeric_limits<double>::min());
  if (products) return applyWithProducts(r, z, turns, *products, size);
  const double in = 1 / size;
  const double* const given_turns = turns ? turns->rows().data : nullptr;
  const auto turnOf = [given_turns](Index i) {
    return Eigen::Map<const Eigen::Quaterniond>(given_turns + std::size_t(i) * row_doubles);
  };
  forRows(r.count, [&](Index i) {
    const Vec3 given = turns ? Vec3(turnOf(i).conjugate() * Vec3(r[i])) : Vec3(r[i]);
    float* const to = fine.b.data() + std::size_t(i) * lanes<3>;
    for (int l = 0; l < 3; ++l) to[l] = float(in * given[l]);
    to[3] = 0;
  });
  cycle(fine, 0);
  const double out = size * scale;
  forRows(r.count, [&](Index i) {
    const float* const from = fine.x.data() + std::size_t(i) * lanes<3>;
    const Vec3 found(out * double(from[0]), out * double(from[1]), out * double(from[2]));
    z[i] = turns ? Vec3(turnOf(i) * found) : found;
    z.data[std::size_t(i) * row_doubles + 3] = 0;
  });
}

void Hierarchy::applyWithProducts(ConstRows r, Rows z, const Vector* turns, ProductLevel& products, double size) {
  products.smoothFromZero(r, z);
  products.residual(r, z, turns, size, fine.y);
  fine.restrictTo(coarse[0].b);
  cycle(coarse[0], 1);
  products.correct(fine.p, coarse[0].x, turns, size * scale, z);
  products.smooth(r, z);
}

std::size_t Hierarchy::bytes() const {
  std::size_t sum = bytesOf(fine) + 8 * last.values.size();
  for (const Level<modes>& level : coarse) sum += bytesOf(level);
  return sum;
}

void Hierarchy::serialize(Archive& archive) {
  std::int64_t count = std::int64_t(coarse.size());
  archive.value("levels", count);
  archive.value("scale", scale);
  archive.list("held", held);
  archive.value("last_unknowns", last.unknowns);
  archive.list("last_order", last.order);
  archive.list("last_first", last.first);
  archive.list("last_start", last.start);
  archive.list("last_values", last.values);
  if (archive.isReading()) last.work.assign(last.order.size() * std::size_t(last.unknowns), 0.0);
  coarse.resize(std::size_t(count));
  serializeLevel(archive, "level0_", fine);
  for (std::size_t k = 0; k < coarse.size(); ++k)
    serializeLevel(archive, "level" + std::to_string(k + 1) + "_", coarse[k]);
}

std::shared_ptr<Hierarchy> makeHierarchy(const BlockMatrix& matrix, ConstRows positions, SolveReport& report,
                                         StopToken stop) {
  const double largest = largestOnDiagonal(matrix);
  if (!std::isfinite(largest) || !(largest > 0)) {
    report.stop = std::isfinite(largest) ? SolveStop::not_definite : SolveStop::not_finite;
    return nullptr;
  }
  auto made = std::make_shared<Hierarchy>();
  made->scale = 1 / largest;
  made->coarse.reserve(30);  // levels stay where they are while the next ones are made
  Motions<3> motions;
  made->held = rigidMotions(viewOf(matrix), positions, motions);
  Builder builder(*made, report, stop);
  if (!builder.build(viewOf(matrix), motions, made->fine, weak_link)) return nullptr;
  return made;
}

}  // namespace stroma::amg
