// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/warped_factor.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

#include "components/iterative_solvers/node_rotation.h"
#include "framework/scene/node.h"

namespace stroma {
namespace {

constexpr double block_product_seconds = 3e-9;

[[noreturn]] void refuseStored() { throw std::runtime_error("the checkpoint holds a factored matrix that is none"); }

/// Shapes (rows + 1) and (blocks).
BlockPattern patternOf(const std::vector<Index>& start, const std::vector<Index>& columns) {
  if (start.empty() || start.front() != 0 || std::size_t(start.back()) != columns.size() ||
      !std::is_sorted(start.begin(), start.end()))
    refuseStored();
  BlockPattern pattern(Index(start.size()) - 1);
  for (Index row = 0; row < pattern.rows(); ++row)
    for (Index s = start[std::size_t(row)]; s < start[std::size_t(row) + 1]; ++s) {
      const Index column = columns[std::size_t(s)];
      if (column < 0 || column >= pattern.rows()) refuseStored();
      pattern.addBlock(row, column);
    }
  return pattern;
}

template <class T>
void serializeNumbers(const std::string& name, Archive::Entry& entry, Archive& archive) {
  std::vector<T> numbers(entry.bytes.size() / sizeof(T));
  std::memcpy(numbers.data(), entry.bytes.data(), entry.bytes.size());
  archive.list(name, numbers);
  entry.bytes.assign(reinterpret_cast<const char*>(numbers.data()), sizeof(T) * numbers.size());
}

/// What a solver remembers of a former matrix, such as the precision in which its factors served: under other names than what it
/// remembers of the matrix itself.
void serializeFormer(DirectSolver& solver, SystemMatrix& former, Archive& archive) {
  Archive present;
  present.enter("former");
  solver.serializeFor(former, present);
  std::map<std::string, Archive::Entry> entries = present.entries();
  for (auto& [key, entry] : entries) {
    const std::string name = "former_" + key.substr(key.find(':') + 1);
    if (entry.kind == Archive::Kind::text)
      archive.value(name, entry.bytes);
    else if (entry.kind == Archive::Kind::real)
      serializeNumbers<double>(name, entry, archive);
    else
      serializeNumbers<std::int64_t>(name, entry, archive);
  }
  if (!archive.isReading()) return;
  Archive stored(std::move(entries));
  stored.enter("former");
  solver.serializeFor(former, stored);
}

}  // namespace

/// Eight nodes at a time, from the turns that they had.
void WarpedFactor::turn(ConstRows x) {
  constexpr Index lanes = 8;
  constexpr double enough = 1e-7;  // [rad]
  const BlockMatrix& matrix = origins_[now_.origin].matrix;
  const Vector& origin = origins_[now_.origin].positions;
  for (Index first = 0; first < matrix.rows(); first += lanes) {
    const Index last = std::min(first + lanes, matrix.rows()) - 1;
    EightRotations eight;
    for (Index k = 0; k < lanes; ++k) {
      const Index i = std::min(first + k, last);
      const auto sum = spreadAround(matrix.rowStart(), matrix.columns(), i, x, origin);
      for (Index c = 0; c < 3; ++c) eight.a.row(k).segment<3>(3 * c) = sum.col(c).head<3>();
      eight.q.row(k) = now_.rotations[std::size_t(i)].coeffs().transpose();
    }
    eight.follow(enough);
    for (Index i = first; i <= last; ++i) {
      now_.rotations[std::size_t(i)].coeffs() = eight.q.row(i - first).transpose();
      matrices_[std::size_t(i)] = now_.rotations[std::size_t(i)].toRotationMatrix();
    }
  }
  now_.turned = true;
}

bool WarpedFactor::follow(SystemMatrix& matrix, SolveReport& report, StopToken stop) {
  start_ = std::chrono::steady_clock::now();
  taken_back_ = {};
  if (now_.renew || !fits(matrix)) return renew(matrix, report, stop);
  if (factored_ != now_.origin && !makeAgain(report, stop)) return false;
  if (now_.key == matrix.key()) return true;
  if (now_.at_once > 0) return --now_.at_once, renew(matrix, report, stop);
  now_.fresh = false;
  ++now_.served;
  if (const ConstRows positions = matrix.positions(); positions.count > 0) turn(positions);
  now_.key = matrix.key();
  return true;
}

/// The factors of the matrix as it is.
bool WarpedFactor::renew(SystemMatrix& matrix, SolveReport& report, StopToken stop) {
  const ConstRows positions = matrix.positions();
  const std::size_t next = 1 - kept_.origin;
  Origin& origin = origins_[next];
  now_.fresh = true;
  now_.rows = -1;
  factored_ = none;
  origin.matrix = matrix.assemble();
  origin.symmetric = matrix.symmetric();
  former_.show(origin.matrix, origin.symmetric);
  factors_ = solver_.factor(former_, report, stop);
  if (!factors_) return false;
  if (work_.count() != matrix.rows()) work_.resize(matrix.rows());
  now_.origin = factored_ = next;
  if (positions.count > 0) {
    if (origin.positions.count() != positions.count) origin.positions.resize(positions.count);
    copy(positions, origin.positions);
    now_.rotations.assign(positions.count, Eigen::Quaterniond::Identity());
    matrices_.resize(positions.count);
  }
  now_.rows = matrix.rows(), now_.key = matrix.key();
  now_.renew = now_.turned = false;
  now_.iteration_seconds = factors_->cost().apply + block_product_seconds * origin.matrix.blocks();
  now_.factor_seconds = factors_->cost().factor;
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start_;
  now_.spent = renewal_ == Renewal::clock ? took.count() : now_.factor_seconds;
  now_.gained = 0, now_.served = 0;
  start_ = std::chrono::steady_clock::now();
  return true;
}

/// Those of the matrix that the memory has.
bool WarpedFactor::makeAgain(SolveReport& report, StopToken stop) {
  const Origin& origin = origins_[now_.origin];
  factored_ = none;
  SolveReport again;
  former_.show(origin.matrix, origin.symmetric);
  factors_ = solver_.factor(former_, again, stop);
  if (!factors_) {
    report.stop = stop.isStopAsked() ? SolveStop::stopped : SolveStop::breakdown;
    return false;
  }
  factored_ = now_.origin;
  if (work_.count() != now_.rows) work_.resize(now_.rows);
  return true;
}

/// Of a solve by former factors; one by fresh factors has nothing to give up for.
int WarpedFactor::patience() const {
  constexpr double least = 10;
  if (now_.fresh || renewal_ == Renewal::never || !(now_.iteration_seconds > 0)) return std::numeric_limits<int>::max();
  return int(std::clamp(now_.factor_seconds / now_.iteration_seconds, least, 1e6));
}

void WarpedFactor::noteRotations() {
  matrices_.clear();
  for (const Eigen::Quaterniond& rotation : now_.rotations) matrices_.push_back(rotation.toRotationMatrix());
}

void WarpedFactor::takeBack(const SystemMatrix& matrix) {
  now_ = kept_;
  taken_back_ = kept_current_ ? matrix.key() : MatrixKey{};
  solver_.takeBackFor(former_);
  noteRotations();
}

void WarpedFactor::Origin::serialize(Archive& archive) {
  std::vector<Index> start = matrix.rowStart(), columns = matrix.columns();
  archive.rows("positions", positions);
  archive.value("factored_symmetric", symmetric);
  archive.list("factored_start", start);
  archive.list("factored_columns", columns);
  if (archive.isReading()) matrix = BlockMatrix(patternOf(start, columns));
  archive.list("factored_values", matrix.values());
  if (matrix.values().size() != 9 * std::size_t(matrix.blocks())) refuseStored();
}

void WarpedFactor::serialize(SystemMatrix& matrix, Archive& archive) {
  Origin& origin = origins_[now_.origin];
  bool is_current = now_.rows >= 0 && isCurrent(matrix);
  archive.value("rows", now_.rows);
  archive.value("current", is_current);
  archive.value("renew", now_.renew);
  archive.value("fresh", now_.fresh);
  archive.value("turned", now_.turned);
  archive.value("rough", now_.rough);
  archive.value("iteration_seconds", now_.iteration_seconds);
  archive.value("factor_seconds", now_.factor_seconds);
  archive.value("spent", now_.spent);
  archive.value("rough_rate", now_.rough_rate);
  archive.value("gained", now_.gained);
  archive.value("last_left", now_.last);
  archive.value("given_up_left", now_.left);
  archive.value("served", now_.served);
  archive.value("at_once", now_.at_once);
  archive.value("failures", now_.failures);
  archive.list("rotations", now_.rotations);
  origin.serialize(archive);
  serializeFormer(solver_, former_, archive);
  if (!archive.isReading()) return;
  factored_ = none;
  taken_back_ = {};
  if (now_.rows < 0) return;
  if (now_.rows != matrix.rows() || origin.matrix.rows() != matrix.rows())
    throw std::runtime_error(
        "the checkpoint holds a factored matrix of another number of nodes: it was written by another scene");
  now_.key = matrix.key();
  if (!is_current) now_.key.values = -1;
  noteRotations();
}

void WarpedFactor::apply(ConstRows r, Rows z) {
  const auto applyFactors = [this](ConstRows in, Rows out) {
    now_.rough ? factors_->applyRoughly(in, out) : factors_->apply(in, out);
  };
  if (!now_.turned) return applyFactors(r, z);
  for (Index i = 0; i < r.count; ++i) work_[i] = matrices_[i].transpose() * r[i];
  applyFactors(work_, z);
  for (Index i = 0; i < r.count; ++i) z[i] = (matrices_[i] * z[i]).eval();
}

SolveReport WarpedFactor::solveFresh(ConstRows b, Rows x, const SolveTerms& terms, double enough) {
  constexpr int applications = 3;
  const SolveReport report = solver_.solve(former_, b, x, terms);
  SolveReport worth = report;
  worth.iterations = applications, worth.relative_residual = std::max(report.relative_residual, enough);
  if (report.stop != SolveStop::stopped) solved(worth, 1);
  return report;
}

void WarpedFactor::solved(const SolveReport& report, double began) {
  const int iterations = report.iterations;
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start_;
  const double cost = renewal_ == Renewal::clock ? took.count() : iterations * now_.iteration_seconds;
  const double decades = std::clamp(-std::log10(std::max(report.relative_residual / began, 1e-16)), 0.0, 16.0), gained = 1 + decades;
  now_.spent += cost;
  now_.gained += gained;
  if (now_.fresh) judgePrecision(iterations, iterations / std::max(1.0, decades));
  if (!now_.fresh && report.stop != SolveStop::iteration_limit) now_.failures = 0;
  now_.renew = renewal_ != Renewal::never && !now_.fresh && cost / gained > now_.spent / now_.gained;
}

/// Factors of the very matrix that need many iterations may be those of a matrix that is ill-conditioned beyond single precision, or
/// products have terms that are not in it. Then double precision helps as little, and costs more.
void WarpedFactor::judgePrecision(int iterations, double rate) {
  constexpr int most_of_a_fresh_factor = 20;
  constexpr double helps = 0.7;
  if (now_.rough && now_.rough_rate == 0 && iterations > most_of_a_fresh_factor)
    now_.rough = false, now_.rough_rate = rate;
  else if (!now_.rough && rate > helps * now_.rough_rate)
    now_.rough = true;
}

DirectSolver& factorSource(const Component& user, const Link<DirectSolver>& link) {
  if (DirectSolver* linked = link.get()) return *linked;
  DirectSolver* found = nullptr;
  for (const auto& component : user.node().components()) {
    auto* solver = dynamic_cast<DirectSolver*>(component.get());
    if (!solver) continue;
    if (found)
      throw ComponentError(
          found->path() + " and " + solver->path() + " both factor: it is not clear whose factors are meant",
          "linearSolver=\"@" + found->name() + "\"");
    found = solver;
  }
  if (!found)
    throw ComponentError(user.node().path() + " has no direct solver whose factors could be turned",
                         "a direct solver in the same node, or linearSolver=\"@path\"", "add <SparseLDLSolver/>");
  found->ensureReady();
  return *found;
}

}  // namespace stroma
