// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

namespace stroma {

/// Where the columns and rows of a factor's supernodes lie; see cholmod_factor.
struct SupernodalPattern {
  int columns = 0, count = 0;
  const int* first = nullptr;   ///< column, shape (count + 1)
  const int* start = nullptr;   ///< of the rows in `rows`, shape (count + 1); the first rows are the columns' own
  const int* offset = nullptr;  ///< of the values, column by column, shape (count + 1)
  const int* rows = nullptr;

  int columnsOf(int s) const { return first[s + 1] - first[s]; }
  int heightOf(int s) const { return start[s + 1] - start[s]; }
  const int* rowsOf(int s) const { return rows + start[s]; }
};

/// Subtrees of an elimination tree that share nothing, and what is left above them; each ascending.
struct TreeParts {
  std::vector<std::vector<int>> parts;
  std::vector<int> top;
};

/// `parent` and `work` of each supernode; children come before parents, and roots have the parent -1.
TreeParts divideTree(const std::vector<int>& parent, const std::vector<double>& work);

/// What a factorisation of a pattern does in which order, from counts alone.
struct SupernodalPlan {
  /// Supernode `from` acts on another by its rows from `done` on, `wide` of which are columns of the other.
  struct Update {
    int from, done, wide;
  };
  std::vector<int> update_start;  ///< shape (supernodes + 1)
  std::vector<Update> updates;    ///< on each supernode, in the order of CHOLMOD's loop
  double flops = 0;               ///< of the whole factorisation
  TreeParts tree;

  const Update* begin(int s) const { return updates.data() + update_start[std::size_t(s)]; }
  const Update* end(int s) const { return updates.data() + update_start[std::size_t(s) + 1]; }
};

SupernodalPlan planOf(const SupernodalPattern& pattern);

}  // namespace stroma
