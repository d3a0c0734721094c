// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/multigrid.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <stdexcept>

#include "components/iterative_solvers/node_rotation.h"
#include "components/iterative_solvers/solver_costs.h"

namespace stroma {
namespace {

/// (A + A^T)/2
BlockMatrix symmetricPart(const BlockMatrix& a) {
  BlockMatrix part = a;
  for (Index row = 0; row < a.rows(); ++row)
    for (Index s = a.rowStart()[row]; s < a.rowStart()[row + 1]; ++s) {
      const Index across = a.slot(a.columns()[s], row);
      for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 3; ++c) {
          double& value = part.values()[9 * std::size_t(s) + 3 * r + c];
          value = 0.5 * (value + a.values()[9 * std::size_t(across) + 3 * c + r]);
        }
    }
  return part;
}

std::shared_ptr<amg::Hierarchy> hierarchyOf(SystemMatrix& matrix, ConstRows positions, SolveReport& report, StopToken stop) {
  const BlockMatrix& a = matrix.assemble();
  auto made = matrix.symmetric() ? amg::makeHierarchy(a, positions, report, stop)
                                 : amg::makeHierarchy(symmetricPart(a), positions, report, stop);
  if (!made) return nullptr;
  made->made_of = matrix.key();
  made->positions = Vector(positions.count);
  if (positions.count > 0) copy(positions, made->positions);
  return made;
}

}  // namespace

bool Multigrid::follow(SystemMatrix& matrix, SolveReport& report, StopToken stop) {
  const bool same = now_.hierarchy && isCurrent(matrix);
  taken_back_ = {};
  if (!fits(matrix) || (now_.renew && !same)) return make(matrix, report, stop) && followByProducts(matrix, report);
  now_.fresh = now_.fresh && same;
  now_.other_pattern = now_.other_pattern || now_.key.pattern != matrix.key().pattern;
  if (!same) turn(matrix);
  now_.key = matrix.key();
  return followByProducts(matrix, report);
}

/// From counts. Pairs in contact that have come or gone since make the pattern of the matrix anew too.
void Multigrid::price(const SystemMatrix& matrix) {
  const double rows = matrix.rows(), blocks = now_.hierarchy->fine.a.blocks(), by_fields = matrix.productCost();
  const double product = by_fields > 0 ? by_fields : BlockMatrix::productCost(blocks, false);
  const double cycle = by_products_ ? IterationCosts::cycleByProducts(rows, product, isTurned()) : IterationCosts::cycle(rows, blocks);
  const double made = IterationCosts::hierarchy(rows, blocks) + IterationCosts::assembly(matrix) +
                      (now_.other_pattern ? IterationCosts::pattern(rows, blocks) : 0);
  iterations_worth_ = made / (cycle + product + IterationCosts::vectors(rows));
}

/// Chooses the finest level. True also where blocks are it.
bool Multigrid::followByProducts(const SystemMatrix& matrix, SolveReport& report) {
  by_products_ = amg::ProductLevel::isWorth(matrix, *now_.hierarchy);
  price(matrix);
  if (!by_products_) return true;
  now_.hierarchy->dropFineBlocks();
  Index row = -1;
  if (products_.follow(matrix, *now_.hierarchy, now_.fresh, now_.stiffest, row)) return true;
  report.stop = SolveStop::not_definite;
  report.row = row;
  return false;
}

/// From the places alone: a run that is taken up again has the same turns. A node turns much as those before it.
void Multigrid::turn(const SystemMatrix& matrix) {
  constexpr double least = 1e-3, enough = 1e-4;  // [rad]
  std::shared_ptr<Vector> turns = std::move(now_.turns);
  const ConstRows x = matrix.positions();
  const Vector& before = now_.hierarchy->positions;
  if (before.count() != matrix.rows() || x.count != matrix.rows() || !matrix.isOfLooseNodes()) return;
  if (turns && turns.use_count() > 1) std::swap(turns, spare_turns_);  // those of the step before stay
  if (!turns || turns.use_count() > 1 || turns->count() != x.count) turns = std::make_shared<Vector>(x.count);
  const auto& a = now_.hierarchy->fine.a;
  const std::vector<Index>& held = now_.hierarchy->held;  // a direction that is held must stay where it is
  std::atomic<bool> has_turned = false;
  amg::forPieces(x.count, amg::piecesOf(x.count), [&](int, Index first, Index end) {
    EightRotations eight;
    auto next_held = std::ranges::lower_bound(held, first);
    for (Index i = first; i < end; i += 8) {
      for (Index k = 0; k < 8; ++k) {
        const auto sum = spreadAround(a.start, a.columns, std::min(i + k, end - 1), x, before);
        for (Index c = 0; c < 3; ++c) eight.a.row(k).segment<3>(3 * c) = sum.col(c).head<3>();
      }
      eight.follow(enough);
      for (Index k = 0; k < std::min<Index>(8, end - i); ++k) {
        auto q = Eigen::Map<Eigen::Quaterniond>(turns->rows().data + std::size_t(i + k) * row_doubles);
        q.coeffs() = eight.q.row(k).transpose();
        if (next_held != held.end() && *next_held == i + k)
          q.setIdentity(), ++next_held;
        else if (q.vec().squaredNorm() > least * least / 4)
          has_turned.store(true, std::memory_order_relaxed);
      }
    }
  });
  (has_turned ? now_.turns : spare_turns_) = std::move(turns);
}

bool Multigrid::make(SystemMatrix& matrix, SolveReport& report, StopToken stop) {
  now_ = {};
  now_.hierarchy = hierarchyOf(matrix, matrix.positions(), report, stop);
  if (!now_.hierarchy) return false;
  now_.fresh = true;
  now_.key = matrix.key();
  ++made_;
  return true;
}

void Multigrid::solved(const SolveReport& report, double began) {
  const double decades = std::max(0.5, std::log10(began / std::max(report.relative_residual, 1e-16)));
  const double rate = report.iterations / decades;
  if (now_.rate == 0 && report.iterations > 0) now_.rate = std::max(rate, 1.0);
  now_.lost += std::max(0.0, report.iterations - now_.rate * decades);
  now_.renew = !now_.fresh && now_.lost > iterations_worth_;
}

void Multigrid::takeBack(const SystemMatrix& matrix) {
  now_ = kept_;
  taken_back_ = kept_current_ ? matrix.key() : MatrixKey{};
}

void Multigrid::serialize(SystemMatrix& matrix, Archive& archive, bool never_changes) {
  bool exists = fits(matrix);
  bool is_current = exists && isCurrent(matrix);
  archive.value("exists", exists);
  archive.value("current", is_current);
  archive.value("fresh", now_.fresh);
  archive.value("renew", now_.renew);
  archive.value("rate", now_.rate);
  archive.value("lost", now_.lost);
  archive.value("stiffest", now_.stiffest);
  bool other_pattern = now_.other_pattern || (exists && now_.key.pattern != matrix.key().pattern);
  archive.value("other_pattern", other_pattern);
  if (archive.isReading()) now_.other_pattern = other_pattern;
  taken_back_ = archive.isReading() ? MatrixKey{} : taken_back_;
  bool is_remade = never_changes && is_current && now_.hierarchy->made_of == now_.key;
  archive.value("remade", is_remade);
  bool is_turned = exists && now_.turns;
  archive.value("turned", is_turned);
  if (archive.isReading()) {
    now_.hierarchy = nullptr;
    now_.turns = is_turned ? std::make_shared<Vector>() : nullptr;
  }
  if (!exists) return;
  if (is_turned) archive.rows("turns", *now_.turns);
  if (archive.isReading()) return readHierarchy(matrix, archive, is_remade, is_current);
  archive.rows("positions", now_.hierarchy->positions);
  if (!is_remade) now_.hierarchy->serialize(archive);
}

void Multigrid::readHierarchy(SystemMatrix& matrix, Archive& archive, bool is_remade, bool is_current) {
  Vector positions;
  archive.rows("positions", positions);
  if (is_remade) {
    SolveReport report;
    now_.hierarchy = hierarchyOf(matrix, positions, report, {});
    if (!now_.hierarchy)
      throw std::runtime_error(
          "the checkpoint says that the matrix has a multigrid hierarchy, and it has none: it was written by another scene");
  } else {
    now_.hierarchy = std::make_shared<amg::Hierarchy>();
    now_.hierarchy->serialize(archive);
    now_.hierarchy->positions = std::move(positions);
  }
  if (now_.hierarchy->fine.a.rows() != matrix.rows())
    throw std::runtime_error(
        "the checkpoint holds a multigrid hierarchy of another number of nodes: it was written by "
        "another scene");
  now_.key = matrix.key();
  if (!is_current) now_.key.values = -1;
}

}  // namespace stroma
