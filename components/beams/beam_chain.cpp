// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/beams/beam_chain.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "framework/mesh/cell_kind.h"

namespace stroma {

RodSection roundSection(double radius, double inner, double young, double poisson) {
  if (!(inner < radius))
    throw ComponentError(fmt::format("the inner radius is {:g} and the radius {:g}", inner, radius), "an inner radius below the radius");
  RodSection section;
  section.radius = radius;
  section.area = std::numbers::pi * (radius * radius - inner * inner);
  section.about_y = section.about_z = section.area * (radius * radius + inner * inner) / 4;
  section.young = young, section.poisson = poisson;
  return section;
}

void BeamChain::declare(DataTable& table) {
  topology_.declare(table, "mesh whose edges are beams");
  table.add("beams", table_)
      .help("14 numbers each: nodes, 1 where the beam is out, its length, the lengths of the rod at its ends, "
            "its axes in both frames (x y z w)")
      .inValuesOf(14)
      .output();
}

void BeamChain::publish() {
  table_.clear();
  for (const ChainBeam& beam : beams_) {
    for (const double number : {double(beam.a), double(beam.b), beam.is_there ? 1. : 0., beam.length, beam.from, beam.to})
      table_.push_back(number);
    for (const Quaternion* axes : {&beam.axes_a, &beam.axes_b})
      for (Index k = 0; k < 4; ++k) table_.push_back(axes->coeffs()[k]);
  }
  ++revision_;
}

void BeamChain::init() {
  state_ = find<State>(true);
  if (!state_) throw ComponentError("there are no frames that beams could join", "a MechanicalObject of template Rigid3 in the node");
  if (!state_->hasFrames()) throw ComponentError(state_->path() + " has no frames", "a state of template Rigid3");
  edges_ = &topology_.meshWith(cell_kinds::edge, *this, *state_).edges;
}

Placement BeamChain::placementOf(Index node, bool at_rest) const {
  const std::vector<Vec3>& rows = at_rest ? state_->rest_position : state_->position;
  return {rows[std::size_t(2 * node)], turnedBy(rows[std::size_t(2 * node + 1)])};
}

}  // namespace stroma
