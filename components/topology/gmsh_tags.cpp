// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/topology/gmsh_tags.h"

namespace stroma {

void GmshTags::index(const GmshCursor& where) {
  std::int64_t largest = 0;
  for (const std::int64_t tag : tags_) {
    if (tag < 1) where.fail(fmt::format("node number {} is not positive", tag));
    largest = std::max(largest, tag);
  }
  dense_ = std::uint64_t(largest) <= 8 * std::uint64_t(tags_.size()) + 1024;
  if (dense_) node_of_tag_.assign(std::size_t(largest) + 1, -1);
  for (std::size_t n = 0; n < tags_.size(); ++n) {
    if (!dense_) {
      sparse_.push_back({tags_[n], Index(n)});
    } else {
      if (node_of_tag_[tags_[n]] >= 0) where.fail(fmt::format("node number {} appears twice", tags_[n]));
      node_of_tag_[tags_[n]] = Index(n);
    }
  }
  std::sort(sparse_.begin(), sparse_.end());
  for (std::size_t i = 0; i + 1 < sparse_.size(); ++i)
    if (sparse_[i].first == sparse_[i + 1].first)
      where.fail(fmt::format("node number {} appears twice", sparse_[i].first));
}

Index GmshTags::nodeOf(std::int64_t tag, const GmshCursor& where, const char* who) const {
  if (dense_) {
    if (tag > 0 && std::uint64_t(tag) < node_of_tag_.size() && node_of_tag_[tag] >= 0) return node_of_tag_[tag];
  } else {
    const auto it = std::lower_bound(sparse_.begin(), sparse_.end(), std::pair(tag, Index(0)));
    if (it != sparse_.end() && it->first == tag) return it->second;
  }
  where.fail(fmt::format("{} names node {}, which the file does not have", who, tag));
}

}  // namespace stroma
