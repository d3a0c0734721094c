// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/fem/isotropic.h"

namespace stroma {

/// Lame's constants of a cell [Pa], in an array of one for all or one per cell. Its owner may replace them: kernels that keep
/// this are filled with the new ones.
class LameOf {
 public:
  explicit LameOf(const std::vector<Lame>& constants) : constants_(&constants) {}
  Lame operator()(std::size_t cell) const { return (*constants_)[constants_->size() > 1 ? cell : 0]; }

 private:
  const std::vector<Lame>* constants_;
};

}  // namespace stroma
