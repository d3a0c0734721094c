// SPDX-License-Identifier: LGPL-2.1-or-later
// Proofs for whole bodies, which avoid queries of their parts: one pass over the vertices of a body finds the bounding box of
// their displacements. If two such boxes show that no two displacements differ by more than the clearance of every group of
// their parts, no group has to be tested. For a rotating body the rigid motion is subtracted first, which leaves small
// displacements.
#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include "components/contact/contact_candidates.h"

namespace stroma::contact {

/// Parts and groups of a body follow each other.
void Candidates::joinBodies() {
  constexpr int enough = 32;  // vertices that tell how a body turns
  const auto& bodies = surfaces_->bodies();
  bodies_.assign(bodies.size(), {}), body_meetings_.clear(), are_bodies_counted_ = false;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const int first = bodies[b].first_vertex, count = bodies[b].vertices, stride = std::max(1, count / enough);
    for (int v = 0; v < count; ++v) bodies_[b].all.vertices.push_back(first + v);
    for (int v = 0; v < count; v += stride) bodies_[b].some.vertices.push_back(first + v);
    bodies_[b].turned_at.reserve(std::size_t(count));
  }
  for (std::size_t p = parts_.size(); p-- > 0;) {
    WholeBody& body = bodies_[std::size_t(parts_[p].body)];
    body.end_part = std::max(body.end_part, int(p) + 1), body.first_part = int(p);
  }
  for (std::size_t g = part_groups_.size(); g-- > 0;) {
    WholeBody& body = bodies_[std::size_t(parts_[std::size_t(part_groups_[g].first)].body)];
    body.end_group = std::max(body.end_group, int(g) + 1), body.first_group = int(g);
  }
  std::vector<int> number(bodies.size() * bodies.size(), -1);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const auto bodyOf = [this](int group) { return parts_[std::size_t(part_groups_[std::size_t(group)].first)].body; };
    const int a = bodyOf(groups_[g].a), b = bodyOf(groups_[g].b);
    int& at = number[std::size_t(a) * bodies.size() + std::size_t(b)];
    if (at < 0) at = int(body_meetings_.size()), body_meetings_.push_back({.a = a, .b = b});
    body_meetings_[std::size_t(at)].groups.push_back(int(g));
  }
}

void Candidates::countBodies() {
  if (std::exchange(are_bodies_counted_, true)) return;
  for (WholeBody& body : bodies_) body.turned_at.clear();
  for (BodyMeeting& each : body_meetings_) {
    each.room = each.clear = each.away = std::numeric_limits<double>::infinity(), each.near = 0;
    for (const int number : each.groups) {
      MeetingGroup& group = groups_[std::size_t(number)];
      group.count(meetings_, reach);
      each.room = std::min(each.room, group.room), each.clear = std::min(each.clear, group.clear);
      for (const int number_of_meeting : group.meetings) {
        const Meeting& meeting = meetings_[std::size_t(number_of_meeting)];
        each.near = std::max(each.near, meeting.near), each.away = std::min(each.away, meeting.near - meeting.used);
      }
    }
  }
}

bool Candidates::areFarther(const std::vector<Vec3>& x, double distance) {
  if (found_at_.empty() || found_at_.size() != x.size() || !pairs_.empty()) return false;
  followBodies(x), is_followed_ = false;
  return std::ranges::all_of(body_meetings_, [&](const BodyMeeting& each) {
    return bodies_[std::size_t(each.a)].has_gone && bodies_[std::size_t(each.b)].has_gone && each.away - each.motion > distance;
  });
}

/// Of bodies at x. True: all of them are fine.
bool Candidates::followBodies(const std::vector<Vec3>& x) {
  countBodies();
  const auto& bodies = surfaces_->bodies();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const std::size_t first = std::size_t(bodies[b].first_vertex), count = std::size_t(bodies[b].vertices);
    bodies_[b].has_gone = boxAround(x.data() + first, found_at_.data() + first, count, bodies_[b].gone);
  }
  bool are_fine = true;
  for (BodyMeeting& each : body_meetings_) {
    const WholeBody &a = bodies_[std::size_t(each.a)], &b = bodies_[std::size_t(each.b)];
    const double longest = longestIn(a.gone) + longestIn(b.gone);
    each.motion = boundOfDifference(a.gone, b.gone) + (longest > 0 ? roundOff(longest) : 0);
    each.is_fine = each.room > 0 && a.has_gone && b.has_gone && (each.motion < each.room || turnsAsOne(each, x));
    for (const int group : each.groups) groups_[std::size_t(group)].is_fine = each.is_fine;
    are_fine = are_fine && each.is_fine;
  }
  return are_fine;
}

/// Of a body and itself. True, and its motion is what is left: it has room for that. A tool is asked for many times where it is.
bool Candidates::turnsAsOne(BodyMeeting& each, const std::vector<Vec3>& x) {
  if (each.a != each.b) return false;
  WholeBody& body = bodies_[std::size_t(each.a)];
  const Vec3* const at = x.data() + surfaces_->bodies()[std::size_t(each.a)].first_vertex;
  const std::size_t count = body.all.vertices.size();
  if (body.turned_at.size() == count && std::memcmp(at, body.turned_at.data(), count * sizeof(Vec3)) == 0)
    return each.motion = body.turned, true;
  const double round_off = roundOff(2 * longestIn(body.gone));
  CommonMotion motion = commonMotionTo(body.some, found_at_, x);
  const auto left = [&] { return boundOfDifference(motion, motion) + motion.shrink * (each.near + radii_) + round_off; };
  if (!(left() < each.room)) return false;
  leaveOf(motion, body.all, found_at_, x, nullptr, {});
  if (!(left() < each.room)) return false;
  each.motion = body.turned = left();
  body.turned_at.assign(at, at + count);
  return true;
}

/// Groups of bodies that have room for their ways from x rest; ways of other groups are found. True: there are none. After follow(x).
bool Candidates::restBodies(const std::vector<Vec3>& x, const std::vector<Vec3>& dx, const std::vector<double>& bend) {
  const StepOptions options;
  const auto& bodies = surfaces_->bodies();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const std::size_t first = std::size_t(bodies[b].first_vertex), count = std::size_t(bodies[b].vertices);
    WholeBody& body = bodies_[b];
    body.can_go = boxAround(dx.data() + first, nullptr, count, body.goes), body.is_way_measured = false;
    if (!bend.empty() && count > 0)
      body.goes = body.goes.grownBy(*std::max_element(bend.begin() + long(first), bend.begin() + long(first + count)));
  }
  bool rest = true;
  for (BodyMeeting& each : body_meetings_) {
    const WholeBody &a = bodies_[std::size_t(each.a)], &b = bodies_[std::size_t(each.b)];
    const double way = boundOfDifference(a.goes, b.goes);
    const double most = (1 - options.left) * (each.clear - each.motion - roundOff(longestIn(a.goes) + longestIn(b.goes)));
    const bool rests = a.can_go && b.can_go && (way == 0 || (each.is_fine && (way <= most || goesAsOne(each, x, dx, bend, most))));
    for (const int group : each.groups) groups_[std::size_t(group)].rests = rests;
    rest = rest && rests;
  }
  if (rest) return true;
  goes_way_.set(dx, nullptr);
  for (const BodyMeeting& each : body_meetings_) {
    if (each.groups.empty() || groups_[std::size_t(each.groups.front())].rests) continue;
    if (each.is_fine) {  // then nothing was known of groups
      const bool may_push = may_push_, is_all_known = is_all_known_;
      followParts(each, x);
      may_push_ = may_push, is_all_known_ = is_all_known;
    }
    for (const int number : {each.a, each.b}) {
      WholeBody& body = bodies_[std::size_t(number)];
      if (std::exchange(body.is_way_measured, true)) continue;
      for (int p = body.first_part; p < body.end_part; ++p)
        goes_[std::size_t(p)] = displacementsOf(parts_[std::size_t(p)], goes_way_, bend);
      for (int g = body.first_group; g < body.end_group; ++g)
        part_groups_[std::size_t(g)].join(goes_, part_groups_[std::size_t(g)].goes);
    }
  }
  return false;
}

bool Candidates::goesAsOne(const BodyMeeting& each, const std::vector<Vec3>& x, const std::vector<Vec3>& dx,
                           const std::vector<double>& bend, double most) const {
  if (each.a != each.b) return false;
  const WholeBody& body = bodies_[std::size_t(each.a)];
  CommonMotion motion = commonMotionAlong(body.some, x, dx, bend);
  const auto left = [&] { return boundOfDifference(motion, motion) + motion.shrink * (each.near + radii_); };
  if (!(left() <= most)) return false;
  leaveOf(motion, body.all, x, x, &dx, bend);
  return left() <= most;
}

/// An exact test has found nothing between any two parts, and they have not met since.
bool Candidates::areAllFree() const {
  return std::ranges::all_of(groups_, [](const MeetingGroup& each) { return each.is_fine && each.is_free; });
}

}  // namespace stroma::contact
