// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/passages.h"

#include <fmt/format.h>

#include <algorithm>

namespace stroma::contact {
namespace {

/// Exact: a tenth of each distance is left by every part of the way, so that a way which is free has an end.
bool isFree(const BarrierLaw& law, const std::vector<Vec3>& start, const std::vector<Vec3>& end) {
  constexpr int parts = 20;
  std::vector<Vec3> x = start, left(x.size());
  for (int part = 0; part < parts; ++part) {
    for (std::size_t v = 0; v < x.size(); ++v) left[v] = end[v] - x[v];
    const double step = law.candidates.longestStep(x, left, {});
    if (!(step < 1)) return true;
    for (std::size_t v = 0; v < x.size(); ++v) x[v] += step * left[v];
  }
  return false;
}

/// Beyond planes at the end, by most.
double depthBelowPlanes(const BarrierLaw& law, const std::vector<Vec3>& x, int& vertex) {
  double deepest = 0;
  for (std::size_t p = 0; p < law.planes.size(); ++p)
    for (std::size_t v = 0; v < x.size(); ++v)
      if (const double depth = law.surfaces.moves(int(v)) ? -law.gapToPlane(p, v, x[v]) : 0; depth > deepest)
        deepest = depth, vertex = int(v);
  return deepest;
}

}  // namespace

void Passages::look(const BarrierLaw& law, const std::vector<Touch>& ended, const std::vector<Vec3>& start, const std::vector<Vec3>& end,
                    double time) {
  if (start.size() != end.size()) return;
  constexpr double more = 1.1;  // than before; one that stays is looked at once
  int below = -1;
  const double under = depthBelowPlanes(law, end, below);
  const Touch* deepest = nullptr;
  for (const Touch& touch : ended)
    if (touch.v[1] >= 0 && touch.gap < 0 && !(deepest && touch.gap >= deepest->gap)) deepest = &touch;
  double longest = 0;
  for (std::size_t v = 0; v < end.size(); ++v) longest = std::max(longest, (end[v] - start[v]).norm());
  const double depth = deepest ? -deepest->gap : 0;
  const bool is_deep = depth > more * deepest_, is_far = longest > law.alarm && longest > more * farthest_;
  const bool is_under = under > more * std::max(deepest_, depth);
  const bool goes_through = (is_deep || is_far) && !isFree(law, start, end);
  if (!is_under && !goes_through) return;
  if (++steps_ == 1) first_ = time;
  if (is_under)
    deepest_ = under, one_ = below, other_ = -1;
  else if (is_deep)
    deepest_ = depth, one_ = deepest->v[0], other_ = deepest->v[3];
  else
    farthest_ = longest;
}

std::string Passages::doubt(const std::string& path, const std::function<std::string(int)>& name) const {
  if (steps_ == 0) return {};
  const std::string keeps = "A penalty does not exclude penetration: use a larger stiffness, or a smaller dt with a larger "
                            "alarmDistance; BarrierContact excludes it";
  if (!(deepest_ > 0))
    return fmt::format("something may have passed through a surface of {} by t = {:.6g}: it moved {:.3g} m in a step, farther than "
                       "contacts are looked for. {}",
                       path, first_, farthest_, keeps);
  return fmt::format("surfaces of {} were in one another, first by t = {:.6g}; deepest was {}, {:.3g} m beyond {}. {}", path, first_,
                     name(one_), deepest_, other_ < 0 ? "a plane" : name(other_), keeps);
}

void Passages::serialize(Archive& archive) {
  archive.value("passed_steps", steps_), archive.value("passed_one", one_), archive.value("passed_other", other_);
  archive.value("passed_first", first_), archive.value("passed_deepest", deepest_), archive.value("passed_farthest", farthest_);
}

}  // namespace stroma::contact
