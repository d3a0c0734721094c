// SPDX-License-Identifier: LGPL-2.1-or-later
// Cells of a box and where they lie: outside of a closed surface, in it, or cut by it.
#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "framework/scene/types.h"

namespace stroma::sparse_grid {

enum class Place : char { unknown, border, outside };  ///< unknown in the end: inside

/// Whether a triangle with corners t meets the box of half sizes h around the origin: no axis separates them.
inline bool meetsBox(const std::array<Vec3, 3>& t, const Vec3& h) {
  const auto separates = [&](const Vec3& axis) {
    const double a = axis.dot(t[0]), b = axis.dot(t[1]), c = axis.dot(t[2]), r = h.dot(axis.cwiseAbs());
    return std::min({a, b, c}) > r || std::max({a, b, c}) < -r;
  };
  for (int i = 0; i < 3; ++i)
    if (separates(Vec3::Unit(i))) return false;
  if (separates((t[1] - t[0]).cross(t[2] - t[0]))) return false;
  for (std::size_t e = 0; e < 3; ++e)
    for (int i = 0; i < 3; ++i)
      if (separates((t[(e + 1) % 3] - t[e]).cross(Vec3::Unit(i)))) return false;
  return true;
}

/// Cells of a box, x fastest.
class Cells {
 public:
  Cells(const std::array<int, 3>& count, const Vec3& low, const Vec3& high)
      : count_(count),
        low_(low),
        size_((high - low).cwiseQuotient(Vec3(count[0], count[1], count[2]))),
        places_(std::size_t(count[0]) * std::size_t(count[1]) * std::size_t(count[2]), Place::unknown) {}
  Place& at(int i, int j, int k) { return places_[index(i, j, k)]; }
  Place placeOf(std::size_t cell) const { return places_[cell]; }
  void setPlace(std::size_t cell, Place place) { places_[cell] = place; }
  /// The same cells, with nothing known of them.
  Cells empty() const {
    Cells other = *this;
    std::fill(other.places_.begin(), other.places_.end(), Place::unknown);
    return other;
  }
  std::size_t index(int i, int j, int k) const {
    return std::size_t(i) + std::size_t(count_[0]) * (std::size_t(j) + std::size_t(count_[1]) * std::size_t(k));
  }
  std::size_t size() const { return places_.size(); }

  /// The triangles that meet cells on the border are kept for areNeighbours().
  void keepTriangles() { triangles_.resize(places_.size()); }
  /// Of two cells with a side in common.
  bool areNeighbours(std::size_t a, std::size_t b) const {
    if (places_[a] == Place::outside || places_[b] == Place::outside) return false;
    if (triangles_.empty() || places_[a] != Place::border || places_[b] != Place::border) return true;
    return std::find_first_of(triangles_[a].begin(), triangles_[a].end(), triangles_[b].begin(), triangles_[b].end()) !=
           triangles_[a].end();
  }

  void markBorder(const std::array<Vec3, 3>& corners, int triangle) {
    std::array<int, 3> first{}, last{};
    for (int a = 0; a < 3; ++a) {
      const double least = std::min({corners[0][a], corners[1][a], corners[2][a]});
      const double most = std::max({corners[0][a], corners[1][a], corners[2][a]});
      const double end = count_[std::size_t(a)] - 1;
      first[std::size_t(a)] = int(std::clamp(std::floor((least - low_[a]) / size_[a]), 0., end));
      last[std::size_t(a)] = int(std::clamp(std::floor((most - low_[a]) / size_[a]), 0., end));
    }
    for (int k = first[2]; k <= last[2]; ++k)
      for (int j = first[1]; j <= last[1]; ++j)
        for (int i = first[0]; i <= last[0]; ++i) {
          const Vec3 middle = low_ + size_.cwiseProduct(Vec3(i + 0.5, j + 0.5, k + 0.5));
          if (!meetsBox({corners[0] - middle, corners[1] - middle, corners[2] - middle}, size_ / 2)) continue;
          at(i, j, k) = Place::border;
          if (!triangles_.empty()) triangles_[index(i, j, k)].push_back(triangle);
        }
  }
  /// Spreads from the sides of the box.
  void markOutside() {
    std::vector<std::array<int, 3>> waiting;
    const auto enter = [&](int i, int j, int k) {
      if (i < 0 || j < 0 || k < 0 || i >= count_[0] || j >= count_[1] || k >= count_[2]) return;
      if (at(i, j, k) != Place::unknown) return;
      at(i, j, k) = Place::outside;
      waiting.push_back({i, j, k});
    };
    for (int k = 0; k < count_[2]; ++k)
      for (int j = 0; j < count_[1]; ++j)
        for (int i = 0; i < count_[0]; ++i)
          if (i == 0 || j == 0 || k == 0 || i == count_[0] - 1 || j == count_[1] - 1 || k == count_[2] - 1) enter(i, j, k);
    while (!waiting.empty()) {
      const auto [i, j, k] = waiting.back();
      waiting.pop_back();
      enter(i - 1, j, k), enter(i + 1, j, k), enter(i, j - 1, k), enter(i, j + 1, k), enter(i, j, k - 1), enter(i, j, k + 1);
    }
  }

 private:
  std::array<int, 3> count_;
  Vec3 low_, size_;
  std::vector<Place> places_;
  std::vector<std::vector<int>> triangles_;  ///< of each cell, or empty
};

/// Sets that are joined.
class Sets {
 public:
  explicit Sets(std::size_t count) : of_(count) { std::iota(of_.begin(), of_.end(), std::size_t(0)); }
  std::size_t find(std::size_t i) {
    while (of_[i] != i) i = of_[i] = of_[of_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) { of_[std::max(find(a), find(b))] = find(std::min(find(a), find(b))); }

 private:
  std::vector<std::size_t> of_;
};

}  // namespace stroma::sparse_grid
