// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/path_proofs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "framework/scene/archive.h"

namespace stroma::contact {
namespace {

/// A box of t, u and v.
struct Cell {
  std::array<double, 3> low, high;
};

/// D at the corners of a cell, whose bits say which end of t, u and v.
std::array<Vec3, 8> cornersOf(PairKind kind, const FourPoints& x, const FourPoints& dx, const Cell& cell) {
  std::array<Vec3, 8> out;
  for (unsigned k = 0; k < 8; ++k) {
    const auto end = [&](unsigned i) { return k >> i & 1 ? cell.high[i] : cell.low[i]; };
    const double t = end(0), u = end(1), v = end(2);
    const auto at = [&](std::size_t i) -> Vec3 { return x[i] + t * dx[i]; };
    out[k] = kind == PairKind::edge_edge ? Vec3((1 - u) * at(0) + u * at(1) - (1 - v) * at(2) - v * at(3))
                                         : Vec3(at(0) - (1 - u - v) * at(1) - u * at(2) - v * at(3));
  }
  return out;
}

/// Some direction has products above `least` with all of them: that of their mean, or an axis.
bool areOnOneSide(const std::array<Vec3, 8>& corners, double least) {
  Vec3 mean = Vec3::Zero(), low = corners[0], high = corners[0];
  for (const Vec3& corner : corners) mean += corner, low = low.cwiseMin(corner), high = high.cwiseMax(corner);
  if (low.maxCoeff() > least || high.minCoeff() < -least) return true;
  const double length = mean.norm();
  return length > 0 && std::ranges::all_of(corners, [&](const Vec3& corner) { return mean.dot(corner) > least * length; });
}

}  // namespace

bool isPathFree(PairKind kind, const FourPoints& x, const FourPoints& dx, double slack) {
  constexpr int most = 4000;
  constexpr double rounding = 1e-15;  // of sums of eight products, each with a few roundings
  FourPoints from, way = dx;
  double size = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    from[i] = x[i] - x[0];
    size = std::max({size, from[i].norm(), dx[i].norm(), rounding * 1e3 * x[i].norm()});
  }
  if (!std::isfinite(size)) return false;
  const double least = slack + 32 * rounding * size;
  std::array<Cell, 3 * 53 + 1> waiting;  // one for each time that t, u and v can be halved
  waiting[0] = {{0, 0, 0}, {1, 1, 1}};
  std::size_t count = 1;
  for (int tried = 0; count > 0; ++tried) {
    if (tried == most) return false;
    const Cell cell = waiting[--count];
    if (kind == PairKind::point_triangle && cell.low[1] + cell.low[2] > 1) continue;  // outside of the triangle
    const std::array<Vec3, 8> corners = cornersOf(kind, from, way, cell);
    if (areOnOneSide(corners, least)) continue;
    std::size_t longest = 0;  // of t, u and v, that by which D changes most
    double most_change = -1;
    for (unsigned i = 0; i < 3; ++i) {
      double change = 0;
      for (unsigned k = 0; k < 8; ++k)
        if (!(k >> i & 1)) change = std::max(change, (corners[k | 1u << i] - corners[k]).squaredNorm());
      if (change > most_change) most_change = change, longest = i;
    }
    if (!(most_change > 0) || count + 2 > waiting.size()) return false;
    const double middle = 0.5 * (cell.low[longest] + cell.high[longest]);
    Cell lower = cell, upper = cell;
    lower.high[longest] = upper.low[longest] = middle;
    waiting[count++] = lower, waiting[count++] = upper;
  }
  return true;
}

void PathProofs::compile(const Surfaces& surfaces, bool self_contact) {
  surfaces_ = &surfaces, self_contact_ = self_contact;
  thin_.clear(), forget();
  for (int f = 0; f < int(surfaces.faces.size()); ++f)
    if (isThin(f)) thin_.push_back(f);
  if (thin_.empty()) return;
  last_ = surfaces.rest;
  fitThin(last_);
  thin_tree_.build(thin_boxes_);
  forget();
}

void PathProofs::place(const std::vector<Vec3>& x) {
  if (areNeeded()) last_ = x, bend_.clear();
}

void PathProofs::startAt(const std::vector<Vec3>& x) {
  place(x);
  if (found_ != none) kept_ = std::exchange(found_, none);
}

void PathProofs::startAgain(const std::vector<Vec3>& x) { place(x), found_ = none; }

void PathProofs::placeBodies(const std::vector<Vec3>& x) {
  for (std::size_t v = 0; v < last_.size() && areNeeded(); ++v)
    if (surfaces_->moves(int(v))) last_[v] = x[v];
  bend_.clear();
}

/// A box around the path of a triangle from last_ to x.
Box PathProofs::boxOf(int f, const std::vector<Vec3>& x) const {
  Box box;
  double more = 0;
  for (const int v : surfaces_->faces[std::size_t(f)]) {
    box.add(last_[std::size_t(v)]), box.add(x[std::size_t(v)]);
    if (!bend_.empty()) more = std::max(more, bend_[std::size_t(v)]);
  }
  return box.grownBy(more);
}

void PathProofs::fitThin(const std::vector<Vec3>& x) {
  thin_boxes_.resize(thin_.size());
  for (std::size_t i = 0; i < thin_.size(); ++i) thin_boxes_[i] = boxOf(thin_[i], x);
}

bool PathProofs::mayMeet(int f, int g) const {
  const Surfaces& s = *surfaces_;
  const int v = s.faces[std::size_t(f)][0], w = s.faces[std::size_t(g)][0];
  if (!s.moves(v) && !s.moves(w)) return false;
  const int a = s.bodyOf(v), b = s.bodyOf(w);
  return !s.areExcluded(a, b) && (a != b || self_contact_);
}

void PathProofs::moveTo(const std::vector<Vec3>& x) {
  if (areNeeded() && last_.size() == x.size()) checkPaths(x, false);
  place(x);
}

void PathProofs::allow(const std::vector<Vec3>& x, const std::vector<Vec3>& way, const std::vector<double>& bend, double step) {
  if (!areNeeded()) return;
  last_ = x, bend_ = bend;
  if (bend.empty() || step == 0) return;
  end_ = x;
  for (std::size_t v = 0; v < end_.size(); ++v) end_[v] += step * way[v];
  checkPaths(end_, true);
}

/// One box around the paths of a body: most bodies are far from all thin faces, or stand still with them.
bool PathProofs::mayMeetThin(const Surfaces::Body& body, const std::vector<Vec3>& x) const {
  Box box;
  double more = 0;
  for (std::size_t v = std::size_t(body.first_vertex), end = v + std::size_t(body.vertices); v < end; ++v) {
    box.add(last_[v]), box.add(x[v]);
    if (!bend_.empty()) more = std::max(more, bend_[v]);
  }
  return box.grownBy(more).meets(thin_tree_.whole());
}

void PathProofs::checkPaths(const std::vector<Vec3>& x, bool bent) {
  fitThin(x);
  thin_tree_.refit(thin_boxes_);
  for (const Surfaces::Body& body : surfaces_->bodies()) {
    if (!mayMeetThin(body, x)) continue;
    for (int g = body.first_face; g < body.first_face + body.faces; ++g)
      thin_tree_.forEachMeeting(boxOf(g, x), [&](Index i) {
        const int f = thin_[std::size_t(i)];
        if (mayMeet(f, g) && (!isThin(g) || f < g)) checkFaces(f, g, x, bent);
      });
  }
}

/// A thin one and any. Vertices and edges belong to one triangle each.
void PathProofs::checkFaces(int f, int g, const std::vector<Vec3>& x, bool bent) {
  const Surfaces& s = *surfaces_;
  const auto& face = s.faces[std::size_t(g)];
  if (face[0] != face[1])
    for (const int v : s.owned_vertices[std::size_t(f)])
      if (v >= 0) check(PairKind::point_triangle, {v, face[0], face[1], face[2]}, x, bent);
  for (const int e : s.owned_edges[std::size_t(f)])
    for (const int other : s.owned_edges[std::size_t(g)])
      if (e >= 0 && other >= 0) {
        const auto &p = s.edges[std::size_t(e)], &q = s.edges[std::size_t(other)];
        check(PairKind::edge_edge, {p[0], p[1], q[0], q[1]}, x, bent);
      }
}

void PathProofs::check(PairKind kind, const std::array<int, 4>& v, const std::vector<Vec3>& x, bool bent) {
  const std::size_t first_side = kind == PairKind::point_triangle ? 1 : 2;
  FourPoints from, way;
  double slack[2] = {0, 0};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = first_side; i < first_side && j < 4; ++j)
      if (v[i] == v[j]) return;
    const std::size_t at = std::size_t(v[i]);
    from[i] = last_[at], way[i] = x[at] - last_[at];
    double& of_side = slack[i < first_side ? 0 : 1];
    if (!bend_.empty()) of_side = std::max(of_side, bend_[at]);
  }
  const double all = slack[0] + slack[1];
  if (bent == (all > 0) && !isPathFree(kind, from, way, all)) found_ = {v[0], v[3]};
}

void PathProofs::declare(DataTable& table) {
  table.add("unprovedPaths", steps_)
      .help("steps in which a second test, by another method than the filter, could not prove that no thread, point or ball passed through "
            "another surface or thread")
      .output();
}

void PathProofs::noteStep(const std::function<std::string(int)>& name) {
  const Pair pair = found_ != none ? found_ : kept_;
  kept_ = found_ = none;
  if (pair != none) ++steps_, names_ = name(pair[0]) + " and " + name(pair[1]);
}

std::string PathProofs::doubt(const std::string& path, std::string doubt) const {
  if (steps_ == 0) return doubt;
  return fmt::format("{}{}in {} steps of {} a second test could not prove that no thread or point passed through something, last at {}",
                     doubt, doubt.empty() ? "" : "; ", steps_, path, names_);
}

void PathProofs::serialize(Archive& archive) {
  archive.value("unproved_paths", steps_), archive.value("unproved_names", names_);
  if (archive.isReading()) forget();
}

}  // namespace stroma::contact
