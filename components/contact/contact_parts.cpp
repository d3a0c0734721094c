// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace stroma::contact {

namespace {

/// Three times the middle.
Vec3 middleOf(const Surfaces& s, int face) {
  Vec3 sum = Vec3::Zero();
  for (const int v : s.faces[std::size_t(face)]) sum += s.rest[std::size_t(v)];
  return sum;
}

/// Halves by number until a part has no more than `most` triangles.
void cut(const Surfaces& s, int body, std::vector<int> faces, std::size_t most, std::vector<SurfacePart>& out) {
  if (faces.size() <= most) {
    SurfacePart part{body, std::move(faces), {}};
    std::sort(part.faces.begin(), part.faces.end());
    for (const int f : part.faces)
      part.vertices.insert(part.vertices.end(), s.faces[std::size_t(f)].begin(), s.faces[std::size_t(f)].end());
    std::sort(part.vertices.begin(), part.vertices.end());
    part.vertices.erase(std::unique(part.vertices.begin(), part.vertices.end()), part.vertices.end());
    out.push_back(std::move(part));
    return;
  }
  Box middles;
  for (const int f : faces) middles.add(middleOf(s, f));
  Eigen::Index axis = 0;
  (middles.high - middles.low).maxCoeff(&axis);
  const auto half = faces.begin() + long(faces.size() / 2);
  std::nth_element(faces.begin(), half, faces.end(), [&](int f, int g) {
    const double p = middleOf(s, f)[axis], q = middleOf(s, g)[axis];
    return p != q ? p < q : f < g;
  });
  cut(s, body, {faces.begin(), half}, most, out);
  cut(s, body, {half, faces.end()}, most, out);
}

}  // namespace

std::vector<SurfacePart> partsOf(const Surfaces& surfaces) {
  constexpr std::size_t least = 16;
  const std::size_t most = std::max(least, std::size_t(std::sqrt(double(surfaces.faces.size()))));
  std::vector<SurfacePart> parts;
  for (std::size_t b = 0; b < surfaces.bodies().size(); ++b) {
    std::vector<int> faces(std::size_t(surfaces.bodies()[b].faces));
    std::iota(faces.begin(), faces.end(), surfaces.bodies()[b].first_face);
    cut(surfaces, int(b), std::move(faces), most, parts);
  }
  return parts;
}

Displacements displacementsOf(const SurfacePart& part, const std::vector<Vec3>& x, const std::vector<Vec3>* from,
                              const std::vector<double>& bend) {
  Displacements all;
  double longest = 0, sum = 0, off = 0;
  for (const int v : part.vertices) {
    const Vec3 u = from ? Vec3(x[std::size_t(v)] - (*from)[std::size_t(v)]) : x[std::size_t(v)];
    all.box.add(u);
    const double square = u.squaredNorm();
    longest = std::max(longest, square), sum += square;
  }
  if (!bend.empty())
    for (const int v : part.vertices) off = std::max(off, bend[std::size_t(v)]), sum += bend[std::size_t(v)];
  all.box = all.box.grownBy(off);
  all.longest = std::isfinite(sum) ? std::sqrt(longest) + off : std::numeric_limits<double>::infinity();
  return all;
}

double mostApart(const Displacements& a, const Displacements& b) {
  const double sum = a.longest + b.longest;
  if (!std::isfinite(sum)) return sum;
  return std::min(sum, (a.box.high - b.box.low).cwiseMax(b.box.high - a.box.low).norm());
}

bool areFar(PairKind kind, const FourPoints& x, const FourPoints* dx, double distance) {
  Box sides[2];
  for (std::size_t i = 0; i < 4; ++i) {
    Box& side = sides[i < (kind == PairKind::point_triangle ? 1 : 2) ? 0 : 1];
    side.add(x[i]);
    if (dx) side.add(Vec3(x[i] + (*dx)[i]));
  }
  const Vec3 apart = (sides[1].low - sides[0].high).cwiseMax(sides[0].low - sides[1].high).cwiseMax(Vec3::Zero());
  return apart.squaredNorm() > distance * distance;
}

double leastApart(const Surfaces& s, int f, int g, const std::vector<Vec3>& x, double least) {
  const auto &p = s.faces[std::size_t(f)], &q = s.faces[std::size_t(g)];
  const auto look = [&](PairKind kind, const std::array<int, 4>& v) {
    const FourPoints at{x[std::size_t(v[0])], x[std::size_t(v[1])], x[std::size_t(v[2])], x[std::size_t(v[3])]};
    if (!areFar(kind, at, nullptr, least)) least = std::min(least, closestPoints(kind, at).distance());
  };
  const auto isOf = [](int v, const std::array<int, 3>& face) { return v == face[0] || v == face[1] || v == face[2]; };
  for (const auto& [one, other] : {std::pair(p, q), std::pair(q, p)})
    for (const int v : one)
      if (!isOf(v, other)) look(PairKind::point_triangle, {v, other[0], other[1], other[2]});
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const int a = p[i], b = p[(i + 1) % 3], c = q[j], d = q[(j + 1) % 3];
      if (a != c && a != d && b != c && b != d) look(PairKind::edge_edge, {a, b, c, d});
    }
  return least;
}

}  // namespace stroma::contact
