// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/elasticity/nodal_patches.h"

#include <algorithm>

namespace stroma {

NodalPatches::NodalPatches(const std::vector<std::array<Index, 4>>& cells, const std::vector<Index>& rows)
    : cells_(cells) {
  std::vector<std::vector<Index>> patch(rows.size());
  for (auto& cell : cells_) {
    const std::array<Index, 4> of_cell = cell;
    for (Index& a : cell) {
      a = Index(std::lower_bound(rows.begin(), rows.end(), a) - rows.begin());
      patch[a].insert(patch[a].end(), of_cell.begin(), of_cell.end());
    }
  }
  start_.assign(1, 0);
  for (auto& of_patch : patch) {
    std::sort(of_patch.begin(), of_patch.end());
    of_patch.erase(std::unique(of_patch.begin(), of_patch.end()), of_patch.end());
    nodes_.insert(nodes_.end(), of_patch.begin(), of_patch.end());
    start_.push_back(nodes_.size());
  }
  b_.assign(nodes_.size(), Vec3::Zero());
  place_.resize(cells.size());
  for (std::size_t e = 0; e < cells.size(); ++e)
    for (std::size_t a = 0; a < 4; ++a) {
      const auto& of_patch = patch[cells_[e][a]];
      for (std::size_t i = 0; i < 4; ++i)
        place_[e][4 * a + i] =
            std::uint32_t(std::lower_bound(of_patch.begin(), of_patch.end(), cells[e][i]) - of_patch.begin());
    }
}

void NodalPatches::addPattern(BlockPattern& pattern) const {
  for (std::size_t a = 0; a + 1 < start_.size(); ++a) pattern.addClique(nodes_.data() + start_[a], int(size(a)));
}

std::vector<Index> NodalPatches::slots(const BlockMatrix& matrix) const {
  std::vector<Index> result;
  for (std::size_t a = 0; a + 1 < start_.size(); ++a)
    for (std::size_t i = start_[a]; i < start_[a + 1]; ++i)
      for (std::size_t j = start_[a]; j < start_[a + 1]; ++j) result.push_back(matrix.slot(nodes_[i], nodes_[j]));
  return result;
}

std::size_t NodalPatches::slotCount() const {
  std::size_t count = 0;
  for (std::size_t a = 0; a + 1 < start_.size(); ++a) count += size(a) * size(a);
  return count;
}

void NodalPatches::addTo(std::vector<Vec3>& vectors, std::size_t cell, const std::array<Vec3, 4>& gradient) const {
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t i = 0; i < 4; ++i) vectors[start_[cells_[cell][a]] + place_[cell][4 * a + i]] += gradient[i];
}

void NodalPatches::assemble(double factor, const std::vector<double>& c, const Index* slots,
                            std::vector<double>& values) const {
  const std::vector<Vec3>& d = d_.empty() ? b_ : d_;
  for (std::size_t a = 0; a + 1 < start_.size(); ++a)
    for (std::size_t i = start_[a]; i < start_[a + 1]; ++i) {
      const Vec3 left = -factor * c[a] * b_[i];
      for (std::size_t j = start_[a]; j < start_[a + 1]; ++j) {
        double* block = values.data() + std::size_t(*slots++) * 9;
        for (int r = 0; r < 3; ++r)
          for (int column = 0; column < 3; ++column) block[3 * r + column] += left[r] * d[j][column];
      }
    }
}

void NodalPatches::assembleDiagonal(double factor, const std::vector<double>& c, std::vector<double>& blocks) const {
  const std::vector<Vec3>& d = d_.empty() ? b_ : d_;
  for (std::size_t a = 0; a + 1 < start_.size(); ++a)
    for (std::size_t i = start_[a]; i < start_[a + 1]; ++i)
      for (int r = 0; r < 3; ++r)
        for (int column = 0; column < 3; ++column)
          blocks[std::size_t(nodes_[i]) * 9 + std::size_t(3 * r + column)] -= factor * c[a] * b_[i][r] * d[i][column];
}

}  // namespace stroma
