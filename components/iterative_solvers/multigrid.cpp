// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/multigrid.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace stroma {
namespace {

/// What an assembly and a hierarchy cost, in iterations with it (measured from 40,000 to 320,000 tetrahedra).
constexpr double iterations_worth = 20;

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
  if (!fits(matrix) || (now_.renew && !same)) return make(matrix, report, stop);
  now_.fresh = now_.fresh && same;
  now_.key = matrix.key();
  return true;
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

void Multigrid::solved(const SolveReport& report) {
  const double decades = std::max(0.5, -std::log10(std::max(report.relative_residual, 1e-16)));
  const double rate = report.iterations / decades;
  if (now_.rate == 0) now_.rate = std::max(rate, 1.0);
  now_.lost += std::max(0.0, report.iterations - now_.rate * decades);
  now_.renew = !now_.fresh && now_.lost > iterations_worth;
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
  taken_back_ = archive.isReading() ? MatrixKey{} : taken_back_;
  bool is_remade = never_changes && is_current && now_.hierarchy->made_of == now_.key;
  archive.value("remade", is_remade);
  if (archive.isReading()) now_.hierarchy = nullptr;
  if (!exists) return;
  if (archive.isReading()) return readHierarchy(matrix, archive, is_remade, is_current);
  if (is_remade)
    archive.rows("positions", now_.hierarchy->positions);
  else
    now_.hierarchy->serialize(archive);
}

void Multigrid::readHierarchy(SystemMatrix& matrix, Archive& archive, bool is_remade, bool is_current) {
  if (is_remade) {
    Vector positions;
    archive.rows("positions", positions);
    SolveReport report;
    now_.hierarchy = hierarchyOf(matrix, positions, report, {});
    if (!now_.hierarchy)
      throw std::runtime_error(
          "the checkpoint says that the matrix has a multigrid hierarchy, and it has none: it was written by another scene");
  } else {
    now_.hierarchy = std::make_shared<amg::Hierarchy>();
    now_.hierarchy->serialize(archive);
  }
  if (now_.hierarchy->fine.a.rows() != matrix.rows())
    throw std::runtime_error(
        "the checkpoint holds a multigrid hierarchy of another number of nodes: it was written by "
        "another scene");
  now_.key = matrix.key();
  if (!is_current) now_.key.values = -1;
}

}  // namespace stroma
