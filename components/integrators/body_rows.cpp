// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/body_rows.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace stroma {

namespace {

/// Of the last load, on each row another one: bodies that are coupled answer otherwise than by themselves.
Vec3 mixedLoad(Index row) {
  const double a = double(row % 7) - 3, b = double(row % 5) - 2, c = double(row % 3) - 1;
  return {1 + 0.1 * a, 0.7 + 0.2 * b, -0.4 + 0.3 * c};
}

}  // namespace

void BodyRows::compile(System& system) {
  system_ = &system;
  key_ = {}, first_.clear(), order_.clear();
}

/// Two rows after each other that nothing else is coupled to.
bool BodyRows::findBodies(SystemMatrix& matrix) {
  const MatrixKey key = matrix.key();
  if (key.matrix == key_.matrix && key.pattern == key_.pattern && !body_of_.empty()) return !first_.empty();
  key_ = key;
  const BlockMatrix& pattern = matrix.pattern();
  const auto& columns = pattern.columns();
  const auto& start = pattern.rowStart();
  const auto isAlone = [&](Index row, Index first) {
    return std::all_of(columns.begin() + start[std::size_t(row)], columns.begin() + start[std::size_t(row) + 1],
                       [first](Index column) { return column == first || column == first + 1; });
  };
  first_.clear(), body_of_.assign(std::size_t(pattern.rows()), -1);
  for (Index row = 0; row + 1 < pattern.rows(); ++row) {
    if (!isAlone(row, row) || !isAlone(row + 1, row)) continue;
    body_of_[std::size_t(row)] = body_of_[std::size_t(row) + 1] = int(first_.size());
    first_.push_back(row++);
  }
  inverse_.resize(first_.size()), rows_of_.resize(first_.size());
  return !first_.empty();
}

void BodyRows::load(int number, Rows out) const {
  clear(out);
  for (const Index first : first_) {
    if (number + 1 < loads)
      out[first + number / 3] = Vec3::Unit(number % 3);
    else
      out[first] = mixedLoad(first), out[first + 1] = mixedLoad(first + 1);
  }
  system_->constraints().project(out);
}

bool BodyRows::takeAnswers(std::span<const Vector> loads_of_all, std::span<const Vector> answers) {
  constexpr double same = 1e-6;
  const ConstRows mixed = loads_of_all[loads - 1].rows();
  for (std::size_t b = 0; b < first_.size(); ++b) {
    Block& inverse = inverse_[b];
    inverse.setZero();
    const std::size_t place = std::size_t(row_doubles * first_[b]);
    for (int k = 0; k + 1 < loads; ++k)
      inverse.col(row_doubles * (k / 3) + k % 3) = Eigen::Map<const Numbers>(answers[std::size_t(k)].rows().data + place);
    const Numbers expected = inverse * Eigen::Map<const Numbers>(mixed.data + place);
    const Eigen::Map<const Numbers> found(answers[loads - 1].rows().data + place);
    if (!((expected - found).norm() <= same * found.norm())) return false;
  }
  return true;
}

/// The blocks of J at the x of the last positions(): always the same pairs of rows.
void BodyRows::readMappings() {
  blocks_.clear();
  for (const Mapping* mapping : system_->actors().mappings) mapping->addJacobian(blocks_);
  if (order_.size() == blocks_.size()) return;
  order_.resize(blocks_.size());
  std::iota(order_.begin(), order_.end(), std::size_t(0));
  std::ranges::stable_sort(order_, {}, [this](std::size_t i) { return blocks_[i].child; });
  begin_.assign(std::size_t(system_->allRows()) + 1, 0);
  for (const JacobianBlock& block : blocks_) ++begin_[std::size_t(block.child) + 1];
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
}

bool BodyRows::add(Index at, const Vec3& gradient, Row& row) const {
  if (gradient.isZero(0)) return true;
  if (at >= system_->independentRows()) {
    for (std::size_t k = begin_[std::size_t(at)]; k < begin_[std::size_t(at) + 1]; ++k) {
      const JacobianBlock& block = blocks_[order_[k]];
      if (!add(block.parent, block.block.transpose() * gradient, row)) return false;
    }
    return true;
  }
  const int body = body_of_[std::size_t(at)];
  if (body < 0) return false;
  const Index first = first_[std::size_t(body)];
  const int side = row.bodies > 0 && row.at[0] == first ? 0 : row.bodies > 1 && row.at[1] == first ? 1 : row.bodies;
  if (side == 2) return false;
  if (side == row.bodies) row.at[std::size_t(row.bodies++)] = first;
  row.j[std::size_t(side)].segment<3>(row_doubles * int(at - first)) += gradient;
  return true;
}

bool BodyRows::take(const LagrangianRows& rows, const std::vector<std::size_t>& live) {
  readMappings();
  for (auto& each : rows_of_) each.clear();
  rows_.resize(live.size());
  for (std::size_t k = 0; k < live.size(); ++k) {
    Row& row = rows_[k];
    row.bodies = 0, row.j.fill(Numbers::Zero());
    for (const auto& [at, gradient] : rows.entriesOf(rows.rows()[live[k]]))
      if (!add(at, gradient, row)) return false;
    for (int side = row.bodies; side < 2; ++side) row.at[std::size_t(side)] = row.bodies > 0 ? row.at[0] : first_.front();
    for (std::size_t side = 0; side < std::size_t(row.bodies); ++side)
      rows_of_[std::size_t(body_of_[std::size_t(row.at[side])])].push_back(int(k));
  }
  touched_ = int(std::ranges::count_if(rows_of_, [](const auto& each) { return !each.empty(); }));
  return true;
}

void BodyRows::respond() {
  for (Row& row : rows_)
    for (std::size_t side = 0; side < 2; ++side)
      row.y[side].noalias() = inverse_[std::size_t(body_of_[std::size_t(row.at[side])])] * row.j[side];
}

double BodyRows::couple(const Row& i, const Row& j, double factor) {
  double sum = 0;
  for (std::size_t a = 0; a < std::size_t(i.bodies); ++a)
    for (std::size_t b = 0; b < std::size_t(j.bodies); ++b)
      if (i.at[a] == j.at[b]) sum += i.j[a].dot(j.y[b]);
  return factor * sum;
}

void BodyRows::couple(double factor, Eigen::MatrixXd& w) const {
  const auto count = Eigen::Index(rows_.size());
  w.setZero(count, count);
  for (std::size_t j = 0; j < rows_.size(); ++j)
    for (std::size_t side = 0; side < std::size_t(rows_[j].bodies); ++side)
      for (const int i : rows_of_[std::size_t(body_of_[std::size_t(rows_[j].at[side])])])
        w(i, Eigen::Index(j)) = couple(rows_[std::size_t(i)], rows_[j], factor);
}

}  // namespace stroma
