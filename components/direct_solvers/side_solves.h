// SPDX-License-Identifier: LGPL-2.1-or-later
// Many right sides of one supernodal factor. A supernode is passed by in the forward half where no right side of the block has
// a number in it or in what is below it in the elimination tree: of sparse ones, only paths to the root are gone (Gilbert and Peierls
// 1988).
#pragma once
#include <algorithm>
#include <memory>
#include <mutex>
#include <vector>

#include "components/direct_solvers/side_kernels.h"
#include "components/direct_solvers/supernodal_plan.h"
#include "framework/algebra/memory.h"
#include "framework/algebra/parallel.h"

namespace stroma {

/// Those of this machine.
template <class Number>
const SideKernels<Number>& sideKernels();

/// Of each supernode, -1 of roots.
std::vector<int> parentsOf(const SupernodalPattern& pattern);

/// Work space of pieces that run at once.
template <class Work>
class WorkPool {
 public:
  std::unique_ptr<Work> take() {
    const std::lock_guard lock(access_);
    if (free_.empty()) return std::make_unique<Work>();
    std::unique_ptr<Work> work = std::move(free_.back());
    free_.pop_back();
    return work;
  }
  void giveBack(std::unique_ptr<Work> work) {
    const std::lock_guard lock(access_);
    free_.push_back(std::move(work));
  }
  void release() { free_.clear(); }

 private:
  std::mutex access_;
  std::vector<std::unique_ptr<Work>> free_;
};

/// What a block of right sides needs.
template <class Number>
struct SideWork {
  Array<Number> x;            ///< shape (columns, sides)
  std::vector<char> reached;  ///< of each supernode
};

/// Fewer take less time one by one.
constexpr std::size_t few_sides = 4;

/// body(first, count) of blocks of right sides that are as alike as they can be, at once where there are threads.
template <class Number, class Body>
void forSideBlocks(int count, Body&& body) {
  const int blocks = (count + sides<Number> - 1) / sides<Number>;
  parallelFor(blocks, [&](int k) {
    const int first = int(long(count) * k / blocks);
    body(first, int(long(count) * (k + 1) / blocks) - first);
  });
}

/// x of `work` becomes the solution of `count` right sides. numberOf(side, column): a number of theirs. panelOf(s): of a supernode.
template <class Number, class NumberOf, class PanelOf>
void solveSides(const SupernodalPattern& pattern, const std::vector<int>& parent, const PanelOf& panelOf, int count,
                const NumberOf& numberOf, SideWork<Number>& work) {
  work.x.assign(std::size_t(pattern.columns) * sides<Number>, 0);
  work.reached.assign(std::size_t(pattern.count), false);
  Number* const x = work.x.data();
  for (int s = 0; s < pattern.count; ++s) {
    bool has_any = false;
    for (int k = pattern.first[s]; k < pattern.first[s + 1]; ++k)
      for (int side = 0; side < count; ++side) {
        const Number value = Number(numberOf(side, k));
        x[std::size_t(k) * sides<Number> + std::size_t(side)] = value;
        has_any = has_any || value != 0;
      }
    work.reached[std::size_t(s)] = has_any;
  }
  const SideKernels<Number>& kernels = sideKernels<Number>();
  for (int s = 0; s < pattern.count; ++s) {
    if (!work.reached[std::size_t(s)]) continue;
    kernels.forward(panelOf(s), x);
    if (parent[std::size_t(s)] >= 0) work.reached[std::size_t(parent[std::size_t(s)])] = true;
  }
  for (int s = pattern.count - 1; s >= 0; --s) kernels.backward(panelOf(s), x);
}

}  // namespace stroma
