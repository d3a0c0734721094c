// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/mappings/weighted_mapping.h"

#include <fmt/format.h>

namespace stroma {

void WeightedMapping::init() {
  LinkedMapping::init();
  inputs_ = inputs();
  start_ = {0};
  weights_.clear();
}

void WeightedMapping::addNode(const std::vector<Weight>& weights) {
  weights_.insert(weights_.end(), weights.begin(), weights.end());
  start_.push_back(weights_.size());
}

void WeightedMapping::addCopy(Index first_row, int state) {
  const State& from = *inputs_[std::size_t(state)];
  const Index rows = output().rows_per_node;
  for (Index k = 0; k < rows; ++k) {
    const Index own = Index(start_.size()) - 1;
    if (from.rows_per_node < rows || from.kindOf(first_row + k) != output().kindOf(own))
      throw ComponentError(fmt::format("the nodes of {} and {} are of different types", from.path(), output().path()),
                           "states of one template, or points that are the centres of frames");
    addNode({{first_row + k, 1, state}});
  }
}

void WeightedMapping::apply(Rows x) const {
  using Row = Eigen::Map<Eigen::Vector4d>;
  const auto at = [x](Index row) { return Row(x.data + std::size_t(row) * row_doubles); };
  const Index first = output().firstRow();
  for (Index i = 0; i < output().size(); ++i) {
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (std::size_t k = start_[i]; k < start_[i + 1]; ++k) sum += weights_[k].value * at(row(weights_[k]));
    at(first + i) = sum;
  }
}

void WeightedMapping::applyJT(Rows f) const {
  const Index first = output().firstRow();
  for (Index i = 0; i < output().size(); ++i)
    for (std::size_t k = start_[i]; k < start_[i + 1]; ++k) f[row(weights_[k])] += weights_[k].value * f[first + i];
}

void WeightedMapping::addJacobian(std::vector<JacobianBlock>& out) const {
  const Index first = output().firstRow();
  for (Index i = 0; i < output().size(); ++i)
    for (std::size_t k = start_[i]; k < start_[i + 1]; ++k)
      out.push_back({first + i, row(weights_[k]), weights_[k].value * Mat3::Identity()});
}

}  // namespace stroma
