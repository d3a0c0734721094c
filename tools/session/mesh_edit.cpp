// SPDX-License-Identifier: LGPL-2.1-or-later
// Numbers as SOFA has them: what goes is sorted, the largest number first, and the last of the list moves into each hole.
#include "tools/session/mesh_edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "framework/scene/diagnostics.h"

namespace stroma {
namespace {

ListOrigins unchanged(std::size_t count) {
  ListOrigins origins{count, std::vector<Index>(count)};
  std::iota(origins.of.begin(), origins.of.end(), 0);
  return origins;
}

/// Descending, each once. Throws ComponentError for one that the list does not have.
std::vector<Index> checked(std::vector<Index> numbers, std::size_t count, const CellKind& kind) {
  std::sort(numbers.begin(), numbers.end(), std::greater<>());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  if (!numbers.empty() && (numbers.back() < 0 || std::size_t(numbers.front()) >= count))
    throw ComponentError(fmt::format("there is no {} {}: there are {}", kind.singular,
                                     numbers.back() < 0 ? numbers.back() : numbers.front(), count));
  return numbers;
}

template <class T>
void takeOut(std::vector<T>& list, Index number) {
  list[std::size_t(number)] = list.back();
  list.pop_back();
}

/// The cells, as sorted lists of nodes, that hold a node.
class Around {
 public:
  template <class Cell>
  void add(const Cell& cell) {
    std::vector<Index> nodes(cell.begin(), cell.end());
    std::sort(nodes.begin(), nodes.end());
    for (const Index node : nodes) cells_[node].push_back(count_);
    sorted_.push_back(std::move(nodes)), ++count_;
  }
  bool has(Index node) const { return cells_.count(node) > 0; }
  /// Whether one of the cells has all nodes of this one.
  template <class Cell>
  bool contains(const Cell& part) const {
    const auto found = cells_.find(part[0]);
    if (found == cells_.end()) return false;
    return std::any_of(found->second.begin(), found->second.end(), [&](std::size_t number) {
      const std::vector<Index>& whole = sorted_[number];
      return whole.size() > part.size() && std::all_of(part.begin(), part.end(), [&whole](Index node) {
               return std::binary_search(whole.begin(), whole.end(), node);
             });
    });
  }
  const std::map<Index, std::vector<std::size_t>>& nodes() const { return cells_; }

 private:
  std::size_t count_ = 0;
  std::vector<std::vector<Index>> sorted_;
  std::map<Index, std::vector<std::size_t>> cells_;
};

}  // namespace

bool ListOrigins::areTheSame() const {
  if (of.size() != before) return false;
  for (std::size_t i = 0; i < before; ++i)
    if (of[i] != Index(i)) return false;
  return true;
}

std::vector<Index> ListOrigins::now() const {
  std::vector<Index> numbers(before, -1);
  for (std::size_t i = 0; i < of.size(); ++i)
    if (of[i] >= 0) numbers[std::size_t(of[i])] = Index(i);
  return numbers;
}

MeshEdit::MeshEdit(const Mesh& before) {
  mesh_.position = before.position, mesh_.overlap = before.overlap;
  forEachCellList([](const CellKind&, auto& list, const auto& from,
                     auto& origins) { list = from, origins = unchanged(from.size()); },
                  mesh_, before, cells_);
  static_cast<ListOrigins&>(points_) = unchanged(mesh_.position.size());
  for (Index i = 0; i < mesh_.nodes(); ++i) points_.shares.push_back({{i, 1.}});
  is_loose_.assign(mesh_.position.size(), false);
}

MeshChange MeshEdit::byNumbersNow(MeshChange change) const {
  std::vector<Index> now = points_.now();
  forEachCellList(
      [&](const CellKind& kind, const ListOrigins& origins) {
        if (kind.type == change.kind->type) now = origins.now();
      },
      cells_);
  for (Index& number : change.removed)
    if (number >= 0 && std::size_t(number) < now.size()) number = now[std::size_t(number)];
  std::erase(change.removed, -1);
  change.by_first_numbers = false;
  return change;
}

void MeshEdit::make(const MeshChange& change) {
  if (change.by_first_numbers) return make(byNumbersNow(change));
  if (!change.points.empty()) addPoints(change);
  if (!change.removed.empty() && change.kind->type == CellType::point) removePoints(change.removed);
  if (!change.removed.empty() && change.kind->type != CellType::point) removeCells(change);
  if (!change.added.empty()) addCells(change);
}

void MeshEdit::removeCells(const MeshChange& change) {
  Around gone, left;
  forEachCellList(
      [&](const CellKind& kind, auto& list, ListOrigins& origins) {
        if (kind.type != change.kind->type) return;
        for (const Index number : checked(change.removed, list.size(), kind)) {
          gone.add(list[std::size_t(number)]);
          takeOut(list, number), takeOut(origins.of, number);
        }
      },
      mesh_, cells_);
  // of what is left only cells near it are asked for
  std::vector<bool> is_near(mesh_.position.size(), false);
  for (const auto& [node, cells] : gone.nodes()) is_near[std::size_t(node)] = true;
  const auto addNear = [&](const auto& list) {
    for (const auto& cell : list)
      if (std::any_of(cell.begin(), cell.end(), [&is_near](Index node) { return is_near[std::size_t(node)]; })) left.add(cell);
  };
  forEachCellList(
      [&](const CellKind& kind, const auto& list) {
        if (kind.dimension >= change.kind->dimension) addNear(list);
      },
      mesh_);
  // faces and edges of what has gone, and of nothing that is left
  forEachCellList(
      [&](const CellKind& kind, auto& list, ListOrigins& origins) {
        if (kind.dimension >= change.kind->dimension) return;
        for (Index i = Index(list.size()) - 1; i >= 0; --i) {
          const auto part = list[std::size_t(i)];
          if (gone.contains(part) && !left.contains(part)) takeOut(list, i), takeOut(origins.of, i);
        }
      },
      mesh_, cells_);
  forEachCellList(
      [&](const CellKind& kind, const auto& list) {
        if (kind.dimension < change.kind->dimension) addNear(list);
      },
      mesh_);
  std::vector<Index> alone;
  for (const auto& [node, cells] : gone.nodes())
    if (!left.has(node)) alone.push_back(node);
  if (!change.keeps_points) return removePoints(std::move(alone));
  for (const Index node : alone) is_loose_[std::size_t(node)] = true;
}

void MeshEdit::removePoints(std::vector<Index> numbers) {
  numbers = checked(std::move(numbers), mesh_.position.size(), cell_kinds::point);
  if (numbers.empty()) return;
  std::vector<Index> slots(mesh_.position.size());  // numbers before this change
  std::iota(slots.begin(), slots.end(), 0);
  for (const Index number : numbers) {
    takeOut(slots, number), takeOut(mesh_.position, number);
    takeOut(points_.of, number), takeOut(points_.shares, number);
    is_loose_[std::size_t(number)] = is_loose_.back(), is_loose_.pop_back();
  }
  std::vector<Index> now(slots.size() + numbers.size(), -1);
  for (std::size_t i = 0; i < slots.size(); ++i) now[std::size_t(slots[i])] = Index(i);
  forEachCellList(
      [&now](const CellKind& kind, auto& list) {
        for (auto& cell : list)
          for (auto& node : cell) {
            if (now[std::size_t(node)] < 0)
              throw ComponentError(fmt::format("point {} cannot be removed: one of the {} still uses it", node, kind.plural),
                                   "a point without cells");
            node = now[std::size_t(node)];
          }
      },
      mesh_);
}

void MeshEdit::addPoints(const MeshChange& change) {
  for (const auto& shares : change.points) {
    Vec3 place = Vec3::Zero();
    std::map<Index, double> sums;  // of points before all changes
    for (const auto& [point, share] : shares) {
      checked({point}, mesh_.position.size(), cell_kinds::point);
      place += share * mesh_.position[std::size_t(point)];
      for (const auto& [origin, part] : points_.shares[std::size_t(point)]) sums[origin] += share * part;
    }
    mesh_.position.push_back(place);
    points_.of.push_back(-1), points_.shares.emplace_back(sums.begin(), sums.end()), is_loose_.push_back(false);
  }
}

void MeshEdit::addCells(const MeshChange& change) {
  forEachCellList(
      [&](const CellKind& kind, auto& list, ListOrigins& origins) {
        if (kind.type != change.kind->type) return;
        for (const std::vector<Index>& nodes : change.added) {
          typename std::decay_t<decltype(list)>::value_type cell{};
          if (nodes.size() != cell.size())
            throw ComponentError(fmt::format("a new {} has {} points", kind.singular, nodes.size()),
                                 fmt::format("{}", cell.size()));
          checked(nodes, mesh_.position.size(), cell_kinds::point);
          std::copy(nodes.begin(), nodes.end(), cell.begin());
          for (const Index node : nodes) is_loose_[std::size_t(node)] = false;
          list.push_back(cell), origins.of.push_back(-1);
        }
      },
      mesh_, cells_);
}

std::vector<Index> MeshEdit::loosePoints() const {
  std::vector<Index> points;
  for (std::size_t i = 0; i < is_loose_.size(); ++i)
    if (is_loose_[i]) points.push_back(Index(i));
  return points;
}

}  // namespace stroma
