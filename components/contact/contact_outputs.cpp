// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_outputs.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "components/contact/contact_obstacles.h"
#include "framework/scene/archive.h"

namespace stroma::contact {

/// Of the barrier, over kappa: 2 (r - 1) ln r + (r - 1)^2 / r.
static double pressureAt(double r) { return 2 * (r - 1) * std::log(r) + (r - 1) * (r - 1) / r; }

void Outputs::declare(DataTable& table) {
  table.add("crossings", crossings).help("steps after which an edge and a triangle had a point in common").output();
  table.add("openStiffness", open_stiffness_)
      .help("stiffness that would have kept the gaps of the run so far at half of contactDistance; 0: none closed to a tenth of it. The "
            "smaller a gap, the more iterations steps need")
      .unit("Pa")
      .output();
  table.add("queries", queries_)
      .help("searches for near pairs, their ways and exact tests that parts of the surfaces have needed so far")
      .unit("-")
      .output();
  table.add("movedStart", moved_start).help("the longest way of a node by resolveStart").unit("m").output();
  table.add("frictionChange", friction_change)
      .help("relative change of the friction in the last step by another solve")
      .unit("-")
      .output();
  declareForces(table);
}

void Outputs::declareForces(DataTable& table) {
  table.add("smallestGap", smallest_gap_)
      .help("smallest gap after the last step; 0: nothing is near")
      .unit("m")
      .output();
  table.add("contactForces", contact_forces_)
      .help("normal contact force on each node of mstate after the last step")
      .unit("N")
      .output()
      .ofNodes();
  table.add("frictionForces", friction_forces_).help("friction on each node of mstate in the last step").unit("N").output().ofNodes();
  table.add("pressures", pressures_)
      .help("of each node of mstate: its normal force over its part of the surface that faces this force. Below zero where adhesion "
            "pulls more")
      .unit("Pa")
      .output()
      .ofNodes();
  table.add("contactAreas", areas_)
      .help("of each node of mstate: the part of the surface for which it is pushed")
      .unit("m^2")
      .output()
      .ofNodes();
  table.add("gaps", gaps_)
      .help("of each node of mstate: the smallest gap; the largest one considered if nothing is nearer")
      .unit("m")
      .output()
      .ofNodes();
  table.add("contactStates", states_).help("of each node of mstate: 0: no contact, 1: sticking, 2: sliding").output().ofNodes();
  wrenches_.declare(table);
}

void Outputs::clearNodes(std::size_t nodes, double far) {
  contact_forces_.assign(nodes, Vec3::Zero()), friction_forces_ = contact_forces_;
  pressures_.assign(nodes, 0), areas_ = rubs_ = pressures_;
  gaps_.assign(nodes, far), states_.assign(nodes, 0);
}

void Outputs::noteNodes(const BarrierLaw& law, const Touch& touch, const State& first) {
  const Surfaces& s = law.surfaces;
  const auto nodeOf = [&](int v) { return std::size_t(s.rows[std::size_t(v)] - first.firstRow()); };
  const auto isFirst = [&](int v) { return v >= 0 && s.moves(v) && s.bodyOf(v) == 0; };
  const bool pushes = touch.gap < touch.range;
  for (std::size_t i = 0; i < 4; ++i) {
    if (!isFirst(touch.v[i]) || touch.c[i] == 0) continue;
    double& gap = gaps_[nodeOf(touch.v[i])];
    gap = std::min(gap, touch.gap);
    if (pushes) states_[nodeOf(touch.v[i])] = 2;
  }
  if (pushes && touch.of_surface && isFirst(touch.v[0]))  // of two bodies each has half of the share
    areas_[nodeOf(touch.v[0])] += touch.v[3] >= 0 && s.moves(touch.v[3]) ? 2 * touch.share : touch.share;
}

void Outputs::noteSlides(const Surfaces& s, const Friction& friction, const State& first) {
  for (const Friction::Slide& slide : friction.slides)
    for (std::size_t i = 0; i < 4; ++i) {
      const int v = slide.v[i];
      if (v < 0 || !s.moves(v) || s.bodyOf(v) != 0 || slide.c[i] == 0) continue;
      const std::size_t node = std::size_t(s.rows[std::size_t(v)] - first.firstRow());
      const double rub = std::abs(slide.c[i] * slide.force);
      if (rub > rubs_[node]) rubs_[node] = rub, states_[node] = friction.isSliding(slide) ? 2 : 1;
    }
}

/// From the sum of its normal forces.
void Outputs::findPressure(const BarrierLaw& law, int vertex, const std::vector<Vec3>& x, const State& first) {
  const std::size_t node = std::size_t(law.surfaces.rows[std::size_t(vertex)] - first.firstRow());
  const double force = contact_forces_[node].norm(), sign = std::copysign(1., pressures_[node]);
  // not areas_: a rim that sticks out faces what it lies on at a slant and has next to no share, but others push it all the same
  const double area = force > 0 ? law.shareOf(vertex, contact_forces_[node] * (sign / force), x) : 0;
  pressures_[node] = area > 0 ? sign * force / area : 0;
}

void Outputs::note(const BarrierLaw& law, const std::vector<Touch>& touches, const Friction& friction, const std::vector<Vec3>& x,
                   const std::vector<State*>& bodies) {
  const Surfaces& s = law.surfaces;
  const State& first = *bodies.front();
  double smallest = std::numeric_limits<double>::infinity();
  touched_ = false, smallest_gap_ = 0;
  queries_ = double(law.candidates.work().all());
  const bool is_clear = touches.empty() && friction.slides.empty();
  if (is_clear && is_clear_ && gaps_.size() == std::size_t(first.size())) return;
  clearNodes(std::size_t(first.size()), law.far());
  wrenches_.begin();
  if ((is_clear_ = is_clear)) return;
  forces_.resize(x.size());
  friction.forces(forces_);
  for (std::size_t k = 0; k < friction.terms().size(); ++k)
    wrenches_.add(s, friction.slides[k].v, friction.terms()[k].c, x, friction.terms()[k].force);
  for (std::size_t v = 0; v < x.size(); ++v)
    if (s.moves(int(v)) && s.bodyOf(int(v)) == 0) friction_forces_[std::size_t(s.rows[v] - first.firstRow())] += forces_[v];
  for (const Touch& touch : touches) {
    smallest = std::min(smallest, touch.gap);
    noteNodes(law, touch, first);
    const Vec3 whole = law.forceOf(touch);
    wrenches_.add(s, touch.v, touch.c, x, whole);
    for (std::size_t i = 0; i < 4; ++i) {
      if (touch.v[i] < 0 || !s.moves(touch.v[i]) || s.bodyOf(touch.v[i]) != 0) continue;
      const std::size_t node = std::size_t(s.rows[std::size_t(touch.v[i])] - first.firstRow());
      contact_forces_[node] += touch.c[i] * whole, pressures_[node] += std::abs(touch.c[i]) * whole.dot(touch.n);
    }
  }
  noteSlides(s, friction, first);
  for (std::size_t v = 0; v < x.size(); ++v)
    if (s.moves(int(v)) && s.bodyOf(int(v)) == 0) findPressure(law, int(v), x, first);
  touched_ = std::isfinite(smallest);
  smallest_gap_ = touched_ ? smallest : 0;
  constexpr double closed = 0.1, half = 0.5;
  const double r = smallest_gap_ / law.range;
  if (r > 0 && r < closed)
    open_stiffness_ = std::max(open_stiffness_, law.stiffness * pressureAt(r) / pressureAt(half));
}

void Outputs::clear() {
  reset();
  clearNodes(0, 0), wrenches_.begin();
  smallest_gap_ = 0, is_clear_ = touched_ = knows_noted_ = false;
}

std::string Outputs::overlap(const std::string& path, const std::vector<Candidates::Crossing>& crossings, const Surfaces& surfaces,
                             const std::function<std::string(int)>& name) const {
  if (!crossings.empty())
    return fmt::format("{} edges and triangles of {} cross; {}", crossings.size(), path, describe(crossings.front(), surfaces, name));
  if (touched_ && !(smallest_gap_ > 0)) return fmt::format("a gap of {} is {:.3g} m", path, smallest_gap_);
  return {};
}

void Outputs::noteSettling(double shares) {
  constexpr double much = 0.05;
  unsettled_ += friction_change > much;
  worst_change_ = std::max(worst_change_, friction_change);
  unsettled_shares_ += shares > much;
  worst_shares_ = std::max(worst_shares_, shares);
}

std::string Outputs::doubt() const {
  std::string text;
  if (unsettled_ > 0)
    text = fmt::format(
        "the friction of {} steps had not settled when frictionIterations ended: another solve would have changed it by up to "
        "{:.0f} %. A smaller dt helps",
        unsettled_, 100 * worst_change_);
  if (unsettled_shares_ > 0)
    text += fmt::format("{}the shares of the surface in contact had not settled in {} steps: another solve would have changed forces by up "
                        "to {:.0f} %",
                        text.empty() ? "" : "; ", unsettled_shares_, 100 * worst_shares_);
  return text;
}

void Outputs::serialize(Archive& archive) {
  archive.value("crossings", crossings);
  archive.value("unsettled", unsettled_);
  archive.value("worst_change", worst_change_);
  archive.value("unsettled_shares", unsettled_shares_), archive.value("worst_shares", worst_shares_);
  archive.value("open_stiffness", open_stiffness_);
  archive.value("friction_change", friction_change), archive.value("smallest_gap", smallest_gap_);
  archive.value("queries", queries_), archive.value("touched", touched_);
  archive.list("contact_forces", contact_forces_), archive.list("friction_forces", friction_forces_);
  archive.list("pressures", pressures_), archive.list("areas", areas_);
  archive.list("gaps", gaps_), archive.list("states", states_), wrenches_.serialize(archive);
  is_clear_ = knows_noted_ = false;
}

}  // namespace stroma::contact
