// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/flush_faces.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "components/contact/kept_gaps.h"

namespace stroma::contact {

namespace {

constexpr double steepest = 0.1;  // rad, also of faces that are smaller than the gap

/// Twice the area, outward.
Vec3 areaOf(const std::array<int, 3>& t, const std::vector<Vec3>& x) {
  const Vec3& p = x[std::size_t(t[0])];
  return (x[std::size_t(t[1])] - p).cross(x[std::size_t(t[2])] - p);
}

}  // namespace

void FlushFaces::compile(const Surfaces& s, const std::vector<char>& rigid) {
  constexpr double one_plane = 1e-6;  // rad
  faces_.clear(), begin();
  face_of_.assign(s.faces.size(), -1), edge_faces_.assign(s.edges.size(), {-1, -1}), around_.assign(s.rest.size(), {});
  std::vector<std::array<int, 2>> sides(s.edges.size(), {-1, -1});  // triangles of each edge
  const auto counts = [&](std::size_t t) {
    const int v = s.faces[t][0];
    return rigid[std::size_t(s.bodyOf(v))] && s.isOneSided(v) && s.radius[t] == 0 && areaOf(s.faces[t], s.rest).norm() > 0;
  };
  for (std::size_t t = 0; t < s.faces.size(); ++t)
    for (const int edge : s.face_edges[t])
      if (edge >= 0 && counts(t)) (sides[std::size_t(edge)][0] < 0 ? sides[std::size_t(edge)][0] : sides[std::size_t(edge)][1]) = int(t);
  std::vector<int> open;
  for (std::size_t first = 0; first < s.faces.size(); ++first) {
    if (face_of_[first] >= 0 || !counts(first)) continue;
    const int number = int(faces_.size());
    const Vec3 normal = areaOf(s.faces[first], s.rest).normalized();
    std::size_t largest = first;
    open.assign(1, int(first)), face_of_[first] = number;
    while (!open.empty()) {
      const auto t = std::size_t(open.back());
      open.pop_back();
      if (areaOf(s.faces[t], s.rest).norm() > areaOf(s.faces[largest], s.rest).norm()) largest = t;
      for (const int edge : s.face_edges[t])
        for (const int next : edge < 0 ? std::array{-1, -1} : sides[std::size_t(edge)])
          if (next >= 0 && face_of_[std::size_t(next)] < 0 &&
              (areaOf(s.faces[std::size_t(next)], s.rest).normalized() - normal).norm() < one_plane)
            face_of_[std::size_t(next)] = number, open.push_back(next);
    }
    faces_.push_back(s.faces[largest]);
  }
  vertices_.assign(faces_.size(), {});
  for (std::size_t t = 0; t < s.faces.size(); ++t)
    for (const int v : s.faces[t]) {
      std::vector<int>& all = around_[std::size_t(v)];
      if (face_of_[t] < 0 || std::find(all.begin(), all.end(), face_of_[t]) != all.end()) continue;
      all.push_back(face_of_[t]);
      vertices_[std::size_t(face_of_[t])].push_back(v);
    }
  for (std::size_t e = 0; e < s.edges.size(); ++e)
    for (std::size_t k = 0; k < 2; ++k)
      if (sides[e][k] >= 0) edge_faces_[e][k] = face_of_[std::size_t(sides[e][k])];
  outward_.assign(faces_.size(), {}), at_edges_.clear(), at_triangles_.clear();
  if (!faces_.empty()) facesAt(s.edges, at_edges_), facesAt(s.faces, at_triangles_);
}

/// Those around any vertex of each cell.
void FlushFaces::facesAt(const auto& cells, std::vector<std::vector<int>>& all) const {
  all.assign(cells.size(), {});
  for (std::size_t i = 0; i < cells.size(); ++i)
    for (const int v : cells[i])
      for (const int face : around_[std::size_t(v)])
        if (std::ranges::find(all[i], face) == all[i].end()) all[i].push_back(face);
}

Vec3 FlushFaces::outward(int face, const std::vector<Vec3>& x) const { return areaOf(faces_[std::size_t(face)], x).normalized(); }

const Vec3& FlushFaces::outwardAtStart(int face, const std::vector<Vec3>& x) {
  Outward& known = outward_[std::size_t(face)];
  if (std::exchange(known.step, step_) != step_) known.n = outward(face, x);
  return known.n;
}

/// That of two faces; of another step where it is not known yet.
FlushFaces::Known& FlushFaces::knownOf(int a, int b) {
  const auto find = [&](int first, int second) -> Known& {
    const std::size_t mask = known_.size() - 1;
    std::size_t at = (std::size_t(first) * 0x9e3779b1u + std::size_t(second) * 0x85ebca6bu) & mask;
    while (known_[at].step == step_ && (known_[at].a != first || known_[at].b != second)) at = (at + 1) & mask;
    return known_[at];
  };
  if (2 * known_count_ >= known_.size()) {
    std::vector<Known> old(std::max<std::size_t>(256, 2 * known_.size()));
    std::swap(old, known_);
    for (const Known& each : old)
      if (each.step == step_) find(each.a, each.b) = each;
  }
  Known& known = find(a, b);
  if (known.step != step_) known.a = a, known.b = b, ++known_count_;
  return known;
}

std::span<const int> FlushFaces::numbersOf(const KeptGap& gap) const {
  return std::span(numbers_).subspan(gap.first_meeting, gap.end_of_meetings - gap.first_meeting);
}

bool FlushFaces::isOn(int face, int vertex) const {
  const std::vector<int>& all = around_[std::size_t(vertex)];
  return std::find(all.begin(), all.end(), face) != all.end();
}

bool FlushFaces::isRim(int edge, int face) const {
  const auto& [a, b] = edge_faces_[std::size_t(edge)];
  return (a == face) != (b == face);
}

/// Where the closest points are.
bool FlushFaces::isOnBoth(const KeptGap& gap, const Meeting& meeting) const {
  const std::size_t second = gap.pair->kind == PairKind::edge_edge ? 2 : 1;
  const auto areOn = [&](std::size_t from, std::size_t to, int face) {
    for (std::size_t k = from; k < to; ++k)
      if (gap.c[k] != 0 && !isOn(face, gap.v[k])) return false;
    return true;
  };
  return (areOn(0, second, meeting.a) && areOn(second, 4, meeting.b)) || (areOn(0, second, meeting.b) && areOn(second, 4, meeting.a));
}

/// How much their distance changes along `way`, of the length of their tilt, over what they have in common in its direction [m].
double FlushFaces::openingOf(int a, int b, const Vec3& way, const std::vector<Vec3>& x) const {
  double first = -std::numeric_limits<double>::infinity(), last = -first;
  for (const int face : {a, b}) {
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (const int v : vertices_[std::size_t(face)]) {
      const double at = way.dot(x[std::size_t(v)]);
      least = std::min(least, at), most = std::max(most, at);
    }
    first = std::max(first, least), last = std::min(last, most);
  }
  return last - first;
}

/// The number of that of two faces. -1: they are not flat on each other.
int FlushFaces::meetingOf(int a, int b, double range, const std::vector<Vec3>& x) {
  // most look elsewhere: |m + o|^2 = 2 + 2 m.o
  if (outwardAtStart(a, x).dot(outwardAtStart(b, x)) > -1 + steepest * steepest) return -1;
  Known& known = knownOf(a, b);
  if (std::exchange(known.step, step_) == step_) return known.number;
  const Vec3 &m = outwardAtStart(a, x), &o = outwardAtStart(b, x), way = m + o;
  known.number = -1;
  if (!(m.dot(o) < 0 && way.norm() < steepest) || openingOf(a, b, way, x) > range) return -1;
  meetings_.push_back({.a = a, .b = b, .n = (m - o).normalized(), .tilt = way.norm()});
  return known.number = int(meetings_.size()) - 1;
}

bool FlushFaces::add(KeptGap& gap, const BarrierLaw& law, const std::vector<Vec3>& x) {
  gap.first_meeting = gap.end_of_meetings = numbers_.size();
  if (!gap.pair || faces_.empty()) return false;
  const std::size_t second = gap.pair->kind == PairKind::edge_edge ? 2 : 1;
  if (law.surfaces.bodyOf(gap.v[0]) == law.surfaces.bodyOf(gap.v[second])) return false;
  const auto meet = [&](int f, int g) {
    const int number = meetingOf(std::min(f, g), std::max(f, g), law.range, x);
    const auto own = numbers_.begin() + std::ptrdiff_t(gap.first_meeting);
    if (number < 0 || std::find(own, numbers_.end(), number) != numbers_.end()) return;
    numbers_.push_back(number);
    Meeting& meeting = meetings_[std::size_t(number)];
    if (gap.is_aligned || !(gap.start < meeting.nearest) || !isOnBoth(gap, meeting)) return;
    meeting.nearest = gap.start;
    meeting.is_outside = gap.n.dot(f == meeting.a ? Vec3(-meeting.n) : meeting.n) > 0;
  };
  const auto first_side = std::size_t(gap.pair->first), second_side = std::size_t(gap.pair->second);
  for (const int f : second == 2 ? at_edges_[first_side] : around_[first_side])
    for (const int g : second == 2 ? at_edges_[second_side] : at_triangles_[second_side]) meet(f, g);
  gap.end_of_meetings = numbers_.size();
  return gap.end_of_meetings > gap.first_meeting;
}

/// Along the face that a vertex is on, or the direction of two faces. False: what it is of is not above each other, or in no way a corner.
bool FlushFaces::place(const KeptGap& gap, const Meeting& meeting, const std::vector<Vec3>& x, double together, Corner& corner) const {
  if (gap.flush_at_start == KeptGap::Flush::corner) together *= 2;  // it stays one for the step
  constexpr double parallel = 1e-6, steep = 0.1;
  const bool crosses = gap.pair->kind == PairKind::edge_edge;
  const bool is_forth = isOn(meeting.a, gap.v[0]) && (!crosses || isOn(meeting.a, gap.v[1]));
  const int own = is_forth ? meeting.a : meeting.b, other = is_forth ? meeting.b : meeting.a;
  const Vec3 n = !crosses ? (is_forth ? meeting.of_b : meeting.of_a) : is_forth ? Vec3(-meeting.n) : meeting.n;
  const auto at = [&](std::size_t k) -> const Vec3& { return x[std::size_t(gap.v[k])]; };
  if (crosses ? !(isRim(gap.pair->first, own) && isRim(gap.pair->second, other))
              : !(isOn(own, gap.v[0]) && face_of_[std::size_t(gap.pair->second)] == other))
    return false;
  // ways along the surfaces from the first vertex of each side
  const Vec3 p = crosses ? Vec3(at(1) - at(0)) : Vec3(at(2) - at(1)), q = crosses ? Vec3(at(3) - at(2)) : Vec3(at(3) - at(1));
  const Vec3 from = crosses ? Vec3(at(0) - at(2)) : Vec3(at(0) - at(1)), up = p.cross(q);
  const double size = n.dot(up);
  if (!(std::abs(size) > parallel * p.norm() * q.norm())) return false;
  // from = s p + t q + gap n
  const double s = n.dot(from.cross(q)) / size, t = n.dot(p.cross(from)) / size;
  std::array<double, 4> c{1, s + t - 1, -s, -t};
  bool is_inside = false;
  if (crosses) {
    c = {1 + s, -s, t - 1, -t};
    const double first = together / p.norm(), last = together / q.norm();
    is_inside = -s >= -first && -s <= 1 + first && t >= -last && t <= 1 + last;
  } else {  // how far beyond each edge
    const double height = std::abs(size);
    is_inside = s * height >= -together * q.norm() && t * height >= -together * p.norm() &&
                (1 - s - t) * height >= -together * (p - q).norm();
  }
  if (!is_inside) return false;
  const double across = std::abs(size) / (p.norm() * q.norm());
  corner = {c, n, crosses && across < steep ? 1 : std::abs(size) / up.norm()};
  return true;
}

void FlushFaces::look(std::vector<KeptGap>& gaps, const std::vector<Vec3>& x, double together) {
  if (meetings_.empty()) return;
  for (Meeting& meeting : meetings_) {
    meeting.of_a = outward(meeting.a, x), meeting.of_b = outward(meeting.b, x);
    meeting.n = (meeting.of_a - meeting.of_b).normalized(), meeting.overlaps = false;
  }
  places_.clear();
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    KeptGap& gap = gaps[i];
    gap.flush = KeptGap::Flush::no;
    int flattest = -1;  // of those that it is at a corner of
    Corner corner, there;
    for (const int number : numbersOf(gap)) {
      Meeting& meeting = meetings_[std::size_t(number)];
      if (!meeting.is_outside || !place(gap, meeting, x, together, there)) continue;
      meeting.overlaps = true;
      if (flattest < 0 || meeting.tilt < meetings_[std::size_t(flattest)].tilt) flattest = number, corner = there;
    }
    if (flattest < 0) continue;
    gap.c = corner.c, gap.n = corner.n, gap.upright = corner.upright, gap.flush = KeptGap::Flush::corner;
    Vec3 middle = Vec3::Zero();  // of the two sides
    double apart = 0;
    const bool crosses = gap.pair->kind == PairKind::edge_edge;
    for (std::size_t k = 0; k < 4; ++k)
      middle += (k == 0 || (crosses && k == 1) ? 0.5 : -0.5) * gap.c[k] * x[std::size_t(gap.v[k])];
    for (std::size_t k = 0; k < 4; ++k) apart += gap.upright * gap.c[k] * gap.n.dot(x[std::size_t(gap.v[k])]);
    places_.push_back({flattest, crosses, middle, apart, i});
  }
  for (KeptGap& gap : gaps)
    for (const int number : gap.is_lower_bound ? std::span<const int>() : numbersOf(gap))
      if (gap.flush == KeptGap::Flush::no && meetings_[std::size_t(number)].overlaps && isOnBoth(gap, meetings_[std::size_t(number)]))
        gap.flush = KeptGap::Flush::beside;
  joinNear(gaps, together);
}

/// One of those that are together counts, of a vertex before one of rims.
void FlushFaces::joinNear(std::vector<KeptGap>& gaps, double together) {
  constexpr double alike = 0.025;  // apart, of how far they are along the faces
  std::ranges::sort(places_, {}, [](const Place& place) { return std::tuple(place.meeting, place.x.x(), place.gap); });
  for (auto first = places_.begin(); first != places_.end(); ++first)
    for (auto last = first + 1; last != places_.end() && last->meeting == first->meeting; ++last) {
      if (last->x.x() - first->x.x() > 4 * together || gaps[first->gap].flush == KeptGap::Flush::beside) break;
      KeptGap &one = gaps[first->gap], &other = gaps[last->gap];
      if (other.flush == KeptGap::Flush::beside) continue;
      // what is one where the step starts stays one for it
      const double far = one.flush_at_start == other.flush_at_start ? 2 * together : 4 * together;
      if ((last->x - first->x).norm() > far || std::abs(last->apart - first->apart) > alike * far) continue;
      const auto rank = [](const KeptGap& gap, const Place& place) {
        return std::tuple(gap.flush_at_start != KeptGap::Flush::corner, place.crosses, place.gap);
      };
      const bool keeps_first = rank(one, *first) < rank(other, *last);
      gaps[keeps_first ? last->gap : first->gap].flush = KeptGap::Flush::beside;
    }
}

}  // namespace stroma::contact
