// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/page_numbers.h"

#include <algorithm>
#include <numeric>

namespace stroma::view {
namespace {

/// Values of what was before, at the numbers of now; -1 for what has come.
std::vector<Index> moved(const std::vector<Index>& values, const std::vector<Index>& now) {
  const Index most = now.empty() ? -1 : *std::max_element(now.begin(), now.end());
  std::vector<Index> out(std::size_t(most + 1), -1);
  for (std::size_t i = 0; i < std::min(values.size(), now.size()); ++i)
    if (now[i] >= 0) out[std::size_t(now[i])] = values[i];
  return out;
}

}  // namespace

void PageNumbers::follow(const Drawing& drawing, const NodesNow& now) {
  for (const auto& [path, numbers] : now) {
    std::vector<Index>& first = first_[path];
    if (first.empty()) {
      first.resize(numbers.size());
      std::iota(first.begin(), first.end(), 0);
    }
    first = moved(first, numbers);
  }
  std::map<std::string, std::vector<Index>> known;
  for (const Body& body : drawing.bodies) {
    const std::string path = body.state->path();
    const auto numbers = now.find(path);
    std::vector<Index> rows = numbers == now.end() ? known_[path] : moved(known_[path], numbers->second);
    // one that follows another mesh has others, and nobody says which
    if (numbers == now.end() && rows.size() != body.page.size()) rows.clear();
    rows.resize(body.page.size(), -1);
    known[path] = std::move(rows);
  }
  known_ = std::move(known);
  untold_ = true;
}

void PageNumbers::told(const Drawing& drawing, int generation) {
  known_.clear();
  for (const Body& body : drawing.bodies) known_[body.state->path()] = body.page;
  generation_ = generation, untold_ = false;
}

std::vector<std::int32_t> PageNumbers::before(const Body& body) const {
  const std::vector<Index>& known = known_.at(body.state->path());
  std::vector<std::int32_t> out;
  for (const Index row : body.node) out.push_back(std::int32_t(known.at(std::size_t(row))));
  return out;
}

}  // namespace stroma::view
