// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_parts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
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

void AllDisplacements::set(const std::vector<Vec3>& x, const std::vector<Vec3>* from) {
  u.resize(x.size() + 1, Vec3::Zero()), squares.resize(x.size());
  const std::size_t count = 3 * x.size();
  if (count == 0) return;
  double* __restrict to = u.front().data();
  const double *at = x.front().data(), *start = from ? from->front().data() : nullptr;
  if (start) {
#pragma omp simd
    for (std::size_t i = 0; i < count; ++i) to[i] = at[i] - start[i];
  } else {
    std::memcpy(to, at, count * sizeof(double));
  }
  double* __restrict square = squares.data();
  for (std::size_t v = 0; v < x.size(); ++v)
    square[v] = to[3 * v] * to[3 * v] + to[3 * v + 1] * to[3 * v + 1] + to[3 * v + 2] * to[3 * v + 2];
}

namespace {
/// Of two vertices or more: numbers of two of them at once, so that a lane is always the same coordinate. The last ones come twice
/// where their number is odd.
template <bool has_start>
bool boxAroundNumbers(const double* x, const double* from, std::size_t count, Box& box) {
  using Two = Eigen::Array2d;
  Two low[3], high[3], sum = Two::Zero();
  for (Two& each : low) each = Two::Constant(std::numeric_limits<double>::infinity());
  for (Two& each : high) each = Two::Constant(-std::numeric_limits<double>::infinity());
  for (std::size_t done = 0; done < count; done += 6) {
    const std::size_t i = std::min(done, count - 6);
    Two u[3] = {Eigen::Map<const Two>(x + i), Eigen::Map<const Two>(x + i + 2), Eigen::Map<const Two>(x + i + 4)};
    if constexpr (has_start) {
      u[0] -= Eigen::Map<const Two>(from + i);
      u[1] -= Eigen::Map<const Two>(from + i + 2);
      u[2] -= Eigen::Map<const Two>(from + i + 4);
    }
    low[0] = low[0].min(u[0]), low[1] = low[1].min(u[1]), low[2] = low[2].min(u[2]);
    high[0] = high[0].max(u[0]), high[1] = high[1].max(u[1]), high[2] = high[2].max(u[2]);
    sum += u[0] + u[1] + u[2];
  }
  box.low = {std::min(low[0][0], low[1][1]), std::min(low[0][1], low[2][0]), std::min(low[1][0], low[2][1])};
  box.high = {std::max(high[0][0], high[1][1]), std::max(high[0][1], high[2][0]), std::max(high[1][0], high[2][1])};
  return std::isfinite(sum.sum());
}
}  // namespace

bool boxAround(const Vec3* x, const Vec3* from, std::size_t count, Box& box) {
  box = {};
  if (count == 0) return false;
  if (count == 1) {
    box.add(from ? Vec3(*x - *from) : *x);
    return box.low.allFinite();
  }
  return from ? boxAroundNumbers<true>(x->data(), from->data(), 3 * count, box)
              : boxAroundNumbers<false>(x->data(), nullptr, 3 * count, box);
}

Displacements displacementsOf(const SurfacePart& part, const AllDisplacements& way, const std::vector<double>& bend) {
  using Four = Eigen::Array4d;  // the last of which is another vertex'
  Four low = Four::Constant(std::numeric_limits<double>::infinity()), high = -low;
  double longest = 0, sum = 0, off = 0;
  for (const int v : part.vertices) {
    const Four u = Eigen::Map<const Four>(way.u[std::size_t(v)].data());
    low = low.min(u), high = high.max(u);
    const double square = way.squares[std::size_t(v)];
    longest = std::max(longest, square), sum += square;
  }
  Displacements all;
  all.box = {low.head<3>(), high.head<3>()};
  if (!bend.empty())
    for (const int v : part.vertices) off = std::max(off, bend[std::size_t(v)]), sum += bend[std::size_t(v)];
  all.box = all.box.grownBy(off);
  all.longest = std::isfinite(sum) ? std::sqrt(longest) + off : std::numeric_limits<double>::infinity();
  return all;
}

double boundOfDifference(const Displacements& a, const Displacements& b) {
  const double sum = a.longest + b.longest;
  if (!std::isfinite(sum)) return sum;
  return std::min(sum, (a.box.high - b.box.low).cwiseMax(b.box.high - a.box.low).norm());
}

void copyPlaces(const std::vector<Vec3>& from, std::vector<Vec3>& to) {
  to.resize(from.size());
  if (!from.empty()) std::memcpy(to.front().data(), from.front().data(), 3 * from.size() * sizeof(double));
}

bool areSame(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3)) == 0);
}

void PartGroup::join(const std::vector<Displacements>& of_parts, Displacements& out) const {
  out = of_parts[std::size_t(first)];
  for (std::size_t p = std::size_t(first) + 1; p < std::size_t(end); ++p)
    out.box.add(of_parts[p].box), out.longest = std::max(out.longest, of_parts[p].longest);
}

void MeetingGroup::count(const std::vector<Meeting>& all, double reach) {
  if (std::exchange(is_counted, true)) return;
  room = clear = std::numeric_limits<double>::infinity();
  for (const int m : meetings) {
    const Meeting& meeting = all[std::size_t(m)];
    const double until_push = meeting.pushing - reach;
    clear = std::min(clear, meeting.clear - meeting.used);
    // what pushes already has its motion known
    room = until_push > 0 ? std::min({room, clear, std::min(meeting.near - reach, until_push) - meeting.used}) : -1;
    if (room < 0) break;
  }
}

namespace {

/// Moments of the points of a part and of what belongs to each, about their means.
struct Moments {
  Vec3 p = Vec3::Zero(), d = Vec3::Zero();  // means
  Mat3 pp = Mat3::Zero(), dp = Mat3::Zero();
  template <class Of>
  Moments(const SurfacePart& part, const std::vector<Vec3>& points, const Vec3& middle, Of&& of) {
    for (const int v : part.vertices) {
      const Vec3 r = points[std::size_t(v)] - middle, u = of(v);
      p += r, d += u;
      pp.noalias() += r * r.transpose(), dp.noalias() += u * r.transpose();
    }
    const double count = double(part.vertices.size());
    p /= count, d /= count;
    pp -= count * p * p.transpose(), dp -= count * d * p.transpose();
    p += middle;
  }
};

/// w with w x p nearest to d, from sum p p^T and sum d p^T.
Vec3 rotationVectorOf(const Mat3& pp, const Mat3& dp) {
  const double trace = pp.trace();
  const Mat3 inertia = (1 + 1e-9) * trace * Mat3::Identity() - pp;
  return trace > 0 ? Vec3(inertia.inverse() * Vec3(dp(2, 1) - dp(1, 2), dp(0, 2) - dp(2, 0), dp(1, 0) - dp(0, 1)))
                   : Vec3(Vec3::Zero());
}

/// The S that is nearest to what is left, from sum (what is left) p^T; none along which a part is flat.
Mat3 stretchOf(const Mat3& pp, const Mat3& rest) {
  constexpr double flat = 0.003;  // of its size, squared
  const double trace = pp.trace();
  return trace > 0 ? Mat3(rest * (pp + flat * trace * Mat3::Identity()).inverse()) : Mat3(Mat3::Zero());
}

CommonMotion placed(const SurfacePart& part, const std::vector<Vec3>& points) {
  CommonMotion motion;
  Box box;
  for (const int v : part.vertices) box.add(points[std::size_t(v)]);
  motion.middle = 0.5 * (box.low + box.high);
  motion.half = (box.high - motion.middle).cwiseMax(motion.middle - box.low);
  return motion;
}

/// Turns and stretches, and what they leave.
template <class Of>
void complete(CommonMotion& motion, const Moments& m, const Mat3& turn, const Mat3& stretch, const SurfacePart& part,
              const std::vector<Vec3>& points, Of&& of) {
  motion.gradient = turn + stretch, motion.shrink = stretch.norm();
  motion.shift = m.d - motion.gradient * (m.p - motion.middle);
  for (const int v : part.vertices)
    motion.left.add(Vec3(of(v) - motion.shift - motion.gradient * (points[std::size_t(v)] - motion.middle)));
}

}  // namespace

CommonMotion commonMotionTo(const SurfacePart& part, const std::vector<Vec3>& p, const std::vector<Vec3>& x) {
  constexpr int rounds = 8;  // what is left of the error counts as left over
  constexpr double exact = 1e-24;
  CommonMotion motion = placed(part, p);
  const auto of = [&](int v) { return Vec3(x[std::size_t(v)] - p[std::size_t(v)]); };
  const Moments m(part, p, motion.middle, of);
  const Mat3 to = m.dp + m.pp;
  Mat3 turn = Mat3::Identity();
  for (int round = 0; round < rounds; ++round) {
    const Mat3 now = to * turn.transpose();
    // with the mean of both moments, a turn of points that are spread alike in all directions is found in the first round
    const Vec3 w = rotationVectorOf(0.5 * (turn * m.pp * turn.transpose() + 0.5 * (now + now.transpose())), now);
    if (!(w.squaredNorm() > exact)) break;
    turn = Eigen::Quaterniond(1, 0.5 * w.x(), 0.5 * w.y(), 0.5 * w.z()).normalized().toRotationMatrix() * turn;
  }
  complete(motion, m, turn - Mat3::Identity(), stretchOf(m.pp, to - turn * m.pp), part, p, of);
  return motion;
}

CommonMotion commonMotionAlong(const SurfacePart& part, const std::vector<Vec3>& p, const std::vector<Vec3>& dx,
                               const std::vector<double>& bend) {
  CommonMotion motion = placed(part, p);
  const auto of = [&](int v) -> const Vec3& { return dx[std::size_t(v)]; };
  const Moments m(part, p, motion.middle, of);
  const Vec3 w = rotationVectorOf(m.pp, m.dp);
  Mat3 turn;
  turn << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  complete(motion, m, turn, stretchOf(m.pp, m.dp - turn * m.pp), part, p, of);
  double off = 0;
  if (!bend.empty())
    for (const int v : part.vertices) off = std::max(off, bend[std::size_t(v)]);
  motion.left = motion.left.grownBy(off);
  return motion;
}

void leaveOf(CommonMotion& motion, const SurfacePart& part, const std::vector<Vec3>& p, const std::vector<Vec3>& x,
             const std::vector<Vec3>* dx, const std::vector<double>& bend) {
  double off = 0;
  motion.left = {};
  for (const int vertex : part.vertices) {
    const std::size_t v = std::size_t(vertex);
    const Vec3 u = dx ? (*dx)[v] : Vec3(x[v] - p[v]);
    motion.left.add(Vec3(u - motion.shift - motion.gradient * (p[v] - motion.middle)));
    if (!bend.empty()) off = std::max(off, bend[v]);
  }
  motion.left = motion.left.grownBy(off);
}

double boundOfDifference(const CommonMotion& a, const CommonMotion& b) {
  const Vec3 between = b.shift - a.shift - a.gradient * (b.middle - a.middle);
  const Vec3 more = (b.gradient - a.gradient).cwiseAbs() * b.half;
  const Vec3 low = b.left.low + between - more, high = b.left.high + between + more;
  return (a.left.high - low).cwiseMax(high - a.left.low).norm();
}

/// Of a side of `first` points and one of the others.
template <std::size_t first>
static bool areFar(const FourPoints& x, double distance) {
  double square = 0;
  for (int k = 0; k < 3; ++k) {
    double low[2] = {x[0][k], x[first][k]}, high[2] = {x[0][k], x[first][k]};
    for (std::size_t i = 1; i < 4; ++i) {
      const std::size_t side = i < first ? 0 : 1;
      low[side] = std::min(low[side], x[i][k]), high[side] = std::max(high[side], x[i][k]);
    }
    const double apart = std::max({low[1] - high[0], low[0] - high[1], 0.0});
    square += apart * apart;
  }
  return square > distance * distance;
}

bool areFar(PairKind kind, const FourPoints& x, const FourPoints* dx, double distance) {
  if (!dx) return kind == PairKind::point_triangle ? areFar<1>(x, distance) : areFar<2>(x, distance);
  const std::size_t first_side = kind == PairKind::point_triangle ? 1 : 2;
  double square = 0;
  for (int k = 0; k < 3 && !(square > distance * distance); ++k) {
    double low[2], high[2];
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t side = i < first_side ? 0 : 1;
      const bool begins = i == 0 || i == first_side;
      const double from = x[i][k], to = dx ? from + (*dx)[i][k] : from;
      const double least = std::min(from, to), most = std::max(from, to);
      low[side] = begins ? least : std::min(low[side], least), high[side] = begins ? most : std::max(high[side], most);
    }
    const double apart = std::max({low[1] - high[0], low[0] - high[1], 0.0});
    square += apart * apart;
  }
  return square > distance * distance;
}

namespace {
double squareBetween(const Box& a, const Box& b) {
  return (a.low - b.high).cwiseMax(b.low - a.high).cwiseMax(Vec3::Zero()).squaredNorm();
}
}  // namespace

/// From closest points within both edges go along both of them, the same way where these are parallel: until one of them ends,
/// after no more than half the shorter edge, the square of the distance grows by the square of that way times the difference of
/// their directions. Distances of ends are right to round-off, however parallel edges are.
double leastOfParallel(const FourPoints& x) {
  constexpr double parallel = 1e-6, round_off = 1e-14;  // of the sine, squared; of the size of the pair
  const Vec3 p = x[1] - x[0], q = x[3] - x[2], from = x[0] - x[2];
  const double pp = p.squaredNorm(), qq = q.squaredNorm(), sizes = pp * qq, square = p.cross(q).squaredNorm();
  if (!(square <= parallel * sizes && sizes > std::numeric_limits<double>::min())) return -1;
  const auto toEdge = [](const Vec3& d, const Vec3& along, double length) {
    return (d - std::clamp(d.dot(along) / length, 0.0, 1.0) * along).squaredNorm();
  };
  const double ends = std::min({toEdge(from, q, qq), toEdge(from + p, q, qq), toEdge(-from, p, pp), toEdge(q - from, p, pp)});
  const double differ = 1.01 * std::sqrt(square / sizes) + round_off, way = 0.5 * std::sqrt(std::min(pp, qq));
  const double least = std::sqrt(std::max(0.0, ends - differ * differ * way * way));
  return std::max(0.0, least - round_off * (from.norm() + std::sqrt(std::max(pp, qq))));
}

double leastDistance(PairKind kind, const FourPoints& x) {
  const double least = kind == PairKind::edge_edge ? leastOfParallel(x) : -1;
  return least >= 0 ? least : closestPoints(kind, x).distance();
}

double leastApart(const Surfaces& s, int f, unsigned f_shared, int g, unsigned g_shared, const std::vector<Vec3>& x, double least) {
  if ((f_shared | g_shared) == 0) return least;
  const auto &p = s.faces[std::size_t(f)], &q = s.faces[std::size_t(g)];
  // boxes of the whole of both and of the edges, which are compared often
  std::array<Box, 2> whole;
  for (std::size_t i = 0; i < 3; ++i) whole[0].add(x[std::size_t(p[i])]), whole[1].add(x[std::size_t(q[i])]);
  if (squareBetween(whole[0], whole[1]) > least * least) return least;
  std::array<std::array<Box, 3>, 2> edges;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t side = 0; side < 2; ++side) {
      const auto& face = side == 0 ? p : q;
      const Vec3 &from = x[std::size_t(face[i])], &to = x[std::size_t(face[(i + 1) % 3])];
      edges[side][i] = {from.cwiseMin(to), from.cwiseMax(to)};
    }
  const auto look = [&](PairKind kind, const Box& a, const Box& b, const std::array<int, 4>& v) {
    if (squareBetween(a, b) > least * least) return;
    const auto at = [&](std::size_t i) -> const Vec3& { return x[std::size_t(v[i])]; };
    least = std::min(least, leastDistance(kind, {at(0), at(1), at(2), at(3)}));
  };
  const auto isOf = [](int v, const std::array<int, 3>& face) { return v == face[0] || v == face[1] || v == face[2]; };
  for (std::size_t side = 0; side < 2; ++side) {
    const auto &one = side == 0 ? p : q, &other = side == 0 ? q : p;
    for (std::size_t i = 0; i < 3; ++i)
      if (const Vec3& at = x[std::size_t(one[i])]; ((side == 0 ? f_shared : g_shared) >> i & 1) && !isOf(one[i], other))
        look(PairKind::point_triangle, {at, at}, whole[1 - side], {one[i], other[0], other[1], other[2]});
  }
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const int a = p[i], b = p[(i + 1) % 3], c = q[j], d = q[(j + 1) % 3];
      if (((f_shared >> (3 + i) | g_shared >> (3 + j)) & 1) && a != c && a != d && b != c && b != d)
        look(PairKind::edge_edge, edges[0][i], edges[1][j], {a, b, c, d});
    }
  return least;
}

std::vector<unsigned> sharedFeatures(const Surfaces& s, const std::vector<SurfacePart>& parts) {
  std::vector<int> of_vertex(s.rows.size(), -1), of_edge(s.edges.size(), -1);
  for (std::size_t p = 0; p < parts.size(); ++p)
    for (const int f : parts[p].faces)
      for (std::size_t k = 0; k < 3; ++k) {
        if (const int v = s.owned_vertices[std::size_t(f)][k]; v >= 0) of_vertex[std::size_t(v)] = int(p);
        if (const int e = s.owned_edges[std::size_t(f)][k]; e >= 0) of_edge[std::size_t(e)] = int(p);
      }
  std::vector<unsigned> bits(s.faces.size(), 0);
  for (std::size_t p = 0; p < parts.size(); ++p)
    for (const int f : parts[p].faces)
      for (std::size_t k = 0; k < 3; ++k) {
        const int e = s.face_edges[std::size_t(f)][k];
        if (of_vertex[std::size_t(s.faces[std::size_t(f)][k])] != int(p)) bits[std::size_t(f)] |= 1u << k;
        if (e < 0 || of_edge[std::size_t(e)] != int(p)) bits[std::size_t(f)] |= 8u << k;
      }
  return bits;
}

}  // namespace stroma::contact
