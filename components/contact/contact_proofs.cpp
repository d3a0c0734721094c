// SPDX-License-Identifier: LGPL-2.1-or-later
// The part of the proofs of Candidates used up by motion, and their serialisation.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "components/contact/contact_candidates.h"
#include "framework/scene/archive.h"

namespace stroma::contact {

namespace {
[[noreturn]] void refuseStored() {
  throw std::runtime_error("the checkpoint has pairs of surfaces that are not there: it was written by another scene");
}

bool isOf(int number, std::size_t count) { return number >= 0 && std::size_t(number) < count; }

/// Of two parts, by the common motion of either, for distances up to `far`.
double leftOver(const CommonMotion& a, const CommonMotion& b, double far) {
  return std::min(boundOfDifference(a, b) + a.shrink * far, boundOfDifference(b, a) + b.shrink * far);
}
}  // namespace

/// As many parts in a group as there are groups.
void Candidates::group() {
  const int most = std::max(1, int(std::sqrt(double(parts_.size()))));
  std::vector<int> of_part;
  part_groups_.clear(), groups_.clear(), group_of_.clear();
  for (int p = 0; p < int(parts_.size()); ++p) {
    const bool goes_on = !part_groups_.empty() && p - part_groups_.back().first < most &&
                         parts_[std::size_t(p)].body == parts_[std::size_t(p) - 1].body;
    if (!goes_on) part_groups_.push_back({.first = p});
    part_groups_.back().end = p + 1, of_part.push_back(int(part_groups_.size()) - 1);
  }
  std::vector<int> number(part_groups_.size() * part_groups_.size(), -1);
  for (const Meeting& meeting : meetings_) {
    const int a = of_part[std::size_t(meeting.a)], b = of_part[std::size_t(meeting.b)];
    int& group = number[std::size_t(a) * part_groups_.size() + std::size_t(b)];
    if (group < 0) group = int(groups_.size()), groups_.push_back({.a = a, .b = b});
    groups_[std::size_t(group)].meetings.push_back(int(group_of_.size()));
    group_of_.push_back(group);
  }
  joinBodies();
}

/// Motion of each meeting at x, or of its group or its bodies where that is enough. True: it is less than what the pairs of each were
/// found for.
bool Candidates::follow(const std::vector<Vec3>& x) {
  if (isFollowed(x)) return is_all_known_;
  may_push_ = true, is_followed_ = false;
  if (found_at_.size() != x.size()) return false;
  is_all_known_ = true, may_push_ = false, has_gone_way_ = false;
  for (WholeBody& body : bodies_) body.is_measured = false;
  const bool are_fine = followBodies(x);
  for (const BodyMeeting& each : body_meetings_)
    if (!each.is_fine) followParts(each, x);
  is_placed_followed_ = x.data() == placed_;
  if (is_placed_followed_)
    followed_.clear(), is_followed_ = true;
  else if (!are_fine)
    followed_ = x, is_followed_ = true;  // else it costs no more to ask again than to remember
  return is_all_known_;
}

/// How far parts and their groups have gone to x.
void Candidates::measureParts(WholeBody& body, const std::vector<Vec3>& x) {
  if (std::exchange(body.is_measured, true)) return;
  if (!std::exchange(has_gone_way_, true)) gone_way_.set(x, &found_at_);
  const std::vector<double> straight;
  for (int p = body.first_part; p < body.end_part; ++p) {
    gone_[std::size_t(p)] = displacementsOf(parts_[std::size_t(p)], gone_way_, straight);
    is_turned_[std::size_t(p)] = false;
  }
  for (int g = body.first_group; g < body.end_group; ++g) part_groups_[std::size_t(g)].join(gone_, part_groups_[std::size_t(g)].gone);
}

/// Motion of each group of two bodies.
void Candidates::followParts(const BodyMeeting& bodies, const std::vector<Vec3>& x) {
  for (const int body : {bodies.a, bodies.b}) measureParts(bodies_[std::size_t(body)], x);
  for (const int group : bodies.groups) {
    MeetingGroup& each = groups_[std::size_t(group)];
    const Displacements &a = part_groups_[std::size_t(each.a)].gone, &b = part_groups_[std::size_t(each.b)].gone;
    const double longest = a.longest + b.longest;
    each.motion = boundOfDifference(a, b) + (longest > 0 ? roundOff(longest) : 0);
    each.is_fine = each.motion < each.room;
    if (!each.is_fine) follow(each, x);
  }
}

/// Motion of each meeting of a group.
void Candidates::follow(MeetingGroup& group, const std::vector<Vec3>& x) {
  group.is_fine = false;
  for (const int m : group.meetings) {
    Meeting& meeting = meetings_[std::size_t(m)];
    // most parts are so far apart that the least known of their motion is enough
    meeting.motion = meeting.used + goneOf(meeting) + roundOffOf(meeting);
    const double budget = budgetOf(meeting), until_push = meeting.pushing - reach;
    const double enough = std::min({budget, meeting.clear, until_push > 0 ? until_push : budget});
    if (meeting.motion >= enough) takeOffShift(meeting);
    if (meeting.motion >= enough) takeOffTurns(meeting, x);
    is_all_known_ = is_all_known_ && meeting.motion <= budget;
    may_push_ = may_push_ || !(meeting.pushing - meeting.motion >= reach);
  }
}

/// Groups that have room for the ways of their parts from x, and a tenth of it besides; of others motion is found. After restBodies().
void Candidates::restGroups(const std::vector<Vec3>& x) {
  const StepOptions options;
  for (MeetingGroup& each : groups_) {
    if (each.rests) continue;
    const Displacements &a = part_groups_[std::size_t(each.a)].goes, &b = part_groups_[std::size_t(each.b)].goes;
    const double way = boundOfDifference(a, b), room = each.clear - each.motion - roundOff(a.longest + b.longest);
    each.rests = way == 0 || (each.is_fine && way <= (1 - options.left) * room);
    if (!each.rests && each.is_fine) follow(each, x);
  }
}

/// Motion of a meeting at the x of the last follow(), less what its parts go along together. That is rounded all the same.
void Candidates::takeOffShift(Meeting& meeting) {
  const Displacements &a = gone_[std::size_t(meeting.a)], &b = gone_[std::size_t(meeting.b)];
  meeting.motion = meeting.used + boundOfDifference(a, b) + roundOffOf(meeting);
}

/// The same, less what each of them does as a whole.
void Candidates::takeOffTurns(Meeting& meeting, const std::vector<Vec3>& x) {
  const double round_off = roundOffOf(meeting);
  if (meeting.near < 0 || !std::isfinite(round_off) || !(meeting.motion > meeting.used + round_off)) return;
  for (const int part : {meeting.a, meeting.b})
    if (!std::exchange(is_turned_[std::size_t(part)], true))
      turned_[std::size_t(part)] = commonMotionTo(parts_[std::size_t(part)], found_at_, x);
  const double motion = meeting.used + round_off + leftOver(turned_[std::size_t(meeting.a)], turned_[std::size_t(meeting.b)],
                                                            meeting.near + radii_);
  if (motion < meeting.motion) meeting.motion = motion;
}

/// The same of a straight way from x, of which `way` is known.
double Candidates::takeOffTurns(const Meeting& meeting, const std::vector<Vec3>& x, const std::vector<Vec3>& dx,
                                const std::vector<double>& bend, double way) {
  if (meeting.near < 0 || !std::isfinite(way)) return way;
  for (const int part : {meeting.a, meeting.b})
    if (!std::exchange(does_turn_[std::size_t(part)], true))
      turns_[std::size_t(part)] = commonMotionAlong(parts_[std::size_t(part)], x, dx, bend);
  const double less = leftOver(turns_[std::size_t(meeting.a)], turns_[std::size_t(meeting.b)], meeting.near + radii_);
  return less < way ? less : way;
}

/// Motion is measured from x from now on; what it was until then has been used up. Not to be called before follow().
void Candidates::startFrom(const std::vector<Vec3>& x) {
  if (found_at_.size() == x.size())
    for (WholeBody& body : bodies_) measureParts(body, x);
  for (Meeting& meeting : meetings_) {
    if (meeting.near >= 0) takeOffShift(meeting), takeOffTurns(meeting, x);
    meeting.used = meeting.motion;
  }
  for (MeetingGroup& each : groups_) each.is_counted = each.is_fine = false;
  for (BodyMeeting& each : body_meetings_) each.is_fine = false;
  are_bodies_counted_ = is_followed_ = false;
  found_at_ = x;
  size_ = 0;
  for (const Vec3& p : x) size_ = std::max(size_, p.cwiseAbs().maxCoeff());
  std::fill(searched_.begin(), searched_.end(), false);
  found_.clear();
  fitNone();
}

/// Pairs are written and not found again: which of them are kept depends on where they were looked for.
void Candidates::serialize(Archive& archive) {
  std::vector<int> pairs, pattern;
  std::vector<double> known, distances;
  for (const Meeting& m : meetings_)
    known.insert(known.end(), {m.near, m.clear, m.pushing, m.used, double(step_ - m.step), double(m.is_free)});
  for (const Candidate& pair : pairs_) {
    pairs.insert(pairs.end(), {int(pair.kind), pair.first, pair.second, pair.meeting});
    distances.push_back(pair.distance);
  }
  archive.list("found_at", found_at_), archive.list("meetings", known);
  for (const PairName& pair : pattern_) pattern.insert(pattern.end(), {int(pair.kind), pair.first, pair.second});
  archive.list("pairs", pairs), archive.list("distances", distances), archive.list("pattern", pattern);
  const std::vector<Vec3> at = found_at_;
  if (archive.isReading()) forget();
  archive.value("searches", work_.searches), archive.value("ways", work_.ways), archive.value("tests", work_.tests);
  if (!archive.isReading()) return;
  // of other obstacles, changed since: searched again
  if (at.size() != surfaces_->rows.size() || known.size() != 6 * meetings_.size()) return;
  startFrom(at);
  for (std::size_t m = 0; m < meetings_.size(); ++m) {
    const double* k = known.data() + 6 * m;
    Meeting& meeting = meetings_[m];
    meeting.near = k[0], meeting.clear = k[1], meeting.pushing = k[2], meeting.used = meeting.motion = k[3];
    meeting.step = step_ - long(k[4]), meeting.is_free = k[5] != 0;
  }
  readPairs(pairs, distances), readPattern(pattern);
}

void Candidates::readPattern(const std::vector<int>& numbers) {
  const Surfaces& s = *surfaces_;
  for (std::size_t i = 0; i + 2 < numbers.size(); i += 3) {
    const bool edges = numbers[i] == int(PairKind::edge_edge);
    const PairName pair{edges ? PairKind::edge_edge : PairKind::point_triangle, numbers[i + 1], numbers[i + 2]};
    if (!isOf(pair.first, edges ? s.edges.size() : s.rows.size()) || !isOf(pair.second, edges ? s.edges.size() : s.faces.size()) ||
        (!pattern_.empty() && !(pattern_.back() < pair)))
      refuseStored();
    pattern_.push_back(pair);
  }
}

void Candidates::readPairs(const std::vector<int>& numbers, const std::vector<double>& distances) {
  const Surfaces& s = *surfaces_;
  if (numbers.size() != 4 * distances.size()) refuseStored();
  for (std::size_t i = 0; i < distances.size(); ++i) {
    const int* n = numbers.data() + 4 * i;
    const bool edges = n[0] == int(PairKind::edge_edge);
    if ((!edges && n[0] != int(PairKind::point_triangle)) || !isOf(n[1], edges ? s.edges.size() : s.rows.size()) ||
        !isOf(n[2], edges ? s.edges.size() : s.faces.size()) || !isOf(n[3], meetings_.size()))
      refuseStored();
    const auto radiusOf = [&](int edge) {
      const int v = s.edges[std::size_t(edge)][0];
      return s.radius[std::size_t(s.faces_around.values[std::size_t(s.faces_around.start[std::size_t(v)])])];
    };
    Candidate pair = edges ? twoEdges(n[1], n[2], radiusOf(n[1]) + radiusOf(n[2])) : vertexAndFace(n[1], n[2]);
    pair.meeting = n[3], pair.distance = distances[i], pair.pushes = !isNearAtRest(pair);
    pairs_.push_back(pair);
  }
}

}  // namespace stroma::contact
