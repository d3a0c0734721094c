// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/multigrid_aggregates.h"

#include <algorithm>

namespace stroma::amg {
namespace {

constexpr Index nowhere = -1;

class Grouping {
 public:
  explicit Grouping(const StrongGraph& graph) : graph_(graph), of_(std::size_t(graph.nodes()), nowhere) {}

  /// Those of nodes with `least` neighbours or more.
  void makeWholeNeighbourhoods(Index least) {
    for (Index i = 0; i < graph_.nodes(); ++i) {
      if (of(i) != nowhere || last(i) - first(i) < least) continue;
      if (std::any_of(first(i), last(i), [this](Index j) { return of(j) != nowhere; })) continue;
      of_[std::size_t(i)] = count_;
      for (const Index* j = first(i); j != last(i); ++j) of_[std::size_t(*j)] = count_;
      ++count_;
    }
  }
  /// The groups that are joined are those of the pass before: a group does not grow into a chain.
  void joinNeighbours() {
    const std::vector<Index> before = of_;
    for (Index i = 0; i < graph_.nodes(); ++i)
      if (of(i) == nowhere) of_[std::size_t(i)] = mostLinked(i, before);
  }
  void makeGroupsOfTheRest() {
    for (Index i = 0; i < graph_.nodes(); ++i) {
      if (of(i) != nowhere || isAlone(i)) continue;
      of_[std::size_t(i)] = count_;
      for (const Index* j = first(i); j != last(i); ++j)
        if (of(*j) == nowhere) of_[std::size_t(*j)] = count_;
      ++count_;
    }
  }
  /// Of a node that has some, rounded up.
  Index meanNeighbours() const {
    Index linked = 0;
    for (Index i = 0; i < graph_.nodes(); ++i) linked += !isAlone(i);
    return (Index(graph_.neighbours.size()) + linked - 1) / std::max<Index>(linked, 1);
  }
  Aggregates result() && {
    Aggregates made;
    made.start.assign(std::size_t(count_) + 1, 0);
    for (const Index group : of_)
      if (group != nowhere) ++made.start[std::size_t(group) + 1];
    for (std::size_t k = 0; k < std::size_t(count_); ++k) made.start[k + 1] += made.start[k];
    made.members.resize(std::size_t(made.start.back()));
    std::vector<Index> next(made.start.begin(), made.start.end());
    for (Index i = 0; i < graph_.nodes(); ++i)
      if (of(i) != nowhere) made.members[std::size_t(next[std::size_t(of(i))]++)] = i;
    made.of = std::move(of_);
    return made;
  }

 private:
  Index of(Index i) const { return of_[std::size_t(i)]; }
  const Index* first(Index i) const { return graph_.neighbours.data() + graph_.start[std::size_t(i)]; }
  const Index* last(Index i) const { return graph_.neighbours.data() + graph_.start[std::size_t(i) + 1]; }
  bool isAlone(Index i) const { return first(i) == last(i); }

  Index mostLinked(Index i, const std::vector<Index>& groups) {
    Index best = nowhere;
    int most = 0;
    for (const Index* j = first(i); j != last(i); ++j) {
      const Index group = groups[std::size_t(*j)];
      if (group == nowhere) continue;
      const int links = int(std::count_if(first(i), last(i), [&](Index k) { return groups[std::size_t(k)] == group; }));
      if (links > most) most = links, best = group;
    }
    return best;
  }

  const StrongGraph& graph_;
  std::vector<Index> of_;
  Index count_ = 0;
};

}  // namespace

Aggregates aggregate(const StrongGraph& graph) {
  Grouping grouping(graph);
  grouping.makeWholeNeighbourhoods(grouping.meanNeighbours());
  grouping.makeWholeNeighbourhoods(1);
  grouping.joinNeighbours();
  grouping.makeGroupsOfTheRest();
  return std::move(grouping).result();
}

}  // namespace stroma::amg
