// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <utility>
#include <vector>

#include "components/topology/gmsh_cursor.h"
#include "framework/scene/types.h"

namespace stroma {

/// Which node a tag of the file means. Tags may have gaps and any order: dense ones get a table, sparse ones a sorted
/// list.
class GmshTags {
 public:
  void reserve(std::size_t count) { tags_.reserve(count); }
  /// The tag of the next node.
  void add(std::int64_t tag) { tags_.push_back(tag); }
  std::size_t size() const { return tags_.size(); }
  /// Once all are there. Fails at the cursor for a tag that is not positive or that appears twice.
  void index(const GmshCursor& where);
  /// Fails at the cursor when there is none: "`who` names node 7, ...".
  Index nodeOf(std::int64_t tag, const GmshCursor& where, const char* who) const;

 private:
  bool dense_ = true;
  std::vector<std::int64_t> tags_;  ///< of each node
  std::vector<Index> node_of_tag_;  ///< dense: -1 for none
  std::vector<std::pair<std::int64_t, Index>> sparse_;
};

}  // namespace stroma
