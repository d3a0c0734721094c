// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/kept_rows.h"

#include <Eigen/Geometry>

namespace stroma::contact {

// Nodes with a weight of zero have a gradient too: the conditions read where they are.
void addRows(const KeptGaps& gaps, const BarrierLaw& law, const std::vector<Vec3>& x, double friction, double reported,
             LagrangianRows& rows) {
  const Surfaces& s = law.surfaces;
  const auto add = [&](const KeptGap& gap, const Vec3& along) {
    for (std::size_t k = 0; k < 4; ++k)
      if (gap.v[k] >= 0 && s.moves(gap.v[k])) rows.add(s.rows[std::size_t(gap.v[k])], gap.c[k] * along);
  };
  for (const KeptGap& gap : gaps.all()) {
    const auto kindOf = [&gap](LagrangianRows::Kind kind) { return gap.is_active ? kind : LagrangianRows::Kind::given; };
    rows.begin(kindOf(LagrangianRows::Kind::push), gap.gap);
    if (!gap.is_lower_bound || !gap.is_rigid) add(gap, gap.n);  // rigid bodies are in no condensed one
    const bool turns_alone = gap.is_active && gap.flush == KeptGap::Flush::no;  // faces that lie flat turn with their bodies
    const KeptGap::Turns turns = turns_alone ? gap.turns(law, x) : KeptGap::Turns();
    for (std::size_t t = 0; t < std::size_t(turns.count); ++t) {
      rows.bend(gap.apart(law));
      for (std::size_t k = 0; k < 4; ++k)
        if (gap.v[k] >= 0 && s.moves(gap.v[k]) && turns.of[t][k] != 0)
          rows.addToBend(s.rows[std::size_t(gap.v[k])], turns.of[t][k] * gap.n);
    }
    if (friction == 0) continue;
    if (gap.is_lower_bound) {  // most of them, and nothing asks along what
      for (int k = 0; k < 2; ++k) rows.begin(LagrangianRows::Kind::given, 0);
      continue;
    }
    const Vec3 slid = gaps.slide(gap, law, x);
    for (const Vec3& tangent : {gap.tangent, Vec3(gap.n.cross(gap.tangent))}) {
      rows.begin(kindOf(LagrangianRows::Kind::rub), tangent.dot(slid), gap.is_active ? friction : 0);
      add(gap, tangent);
    }
  }
  rows.begin(LagrangianRows::Kind::given, 0);  // a condensed body then knows where all of them are
  for (const int v : gaps.watchedVertices())
    if (s.moves(v)) rows.add(s.rows[std::size_t(v)], Vec3::Zero());
  const double unproved = gaps.unproved() > 0 ? gaps.unproved() + reported : 0;
  rows.begin(LagrangianRows::Kind::push, -unproved);  // no force helps where it is below zero; its nodes are for messages
  if (const Candidate* pair = gaps.notFree())
    for (const int v : pair->v)
      if (s.moves(v)) rows.add(s.rows[std::size_t(v)], Vec3::Zero());
}

}  // namespace stroma::contact
