// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_field.h"

#include <fmt/format.h>

#include "components/contact/contact_bodies.h"

namespace stroma::contact {

void ContactField::declare(DataTable& table) {
  ForceField::declare(table);
  listed_.declare(table, "states of other bodies, obstacles if nothing moves them; without any, mstate meets itself and obstacles");
  topology_.declare(table, "mesh whose surface mstate has");
  table.add("contactDistance", law_.range).help("gap below which surfaces push; 0: a tenth of their mean edge").unit("m").min(0);
  table.add("stiffness", stiffness_).help("kappa; 0: a tenth of the largest youngModulus of the bodies").unit("Pa").min(0);
  table.add("thickness", law_.thickness).help("distance of two surfaces at which their gap is zero").unit("m").min(0);
  declareFriction(table, friction_);
  table.add("slipVelocity", slip_velocity_).help("largest creep velocity of sticking contacts").unit("m/s").min(0, false);
  table.add("selfContact", self_).help("a body meets itself; several bodies of one state meet by this too");
  obstacles_.declare(table);
  table.add("moved", law_.moved).help("displacement of obstacles from their given positions").unit("m").output();
}

void ContactField::init() {
  ForceField::init();
  bodies_ = listed_.init(state());
  obstacles_.init(self_ || listed_.areSeveral(), "other, planes, spheres, capsules, cylinders, boxes, meshes or selfContact");
  finishFriction(friction_);
  law_.stiffness = stiffness_ > 0 ? stiffness_ : 0.1 * largestYoungModulus(bodies_);
  if (!(law_.stiffness > 0))
    throw ComponentError("stiffness is not given, and no body here has a youngModulus from which it would follow",
                         "stiffness=\"...\" in pascal, about a tenth of the bodies' Young's modulus");
}

void ContactField::compileSurfaces() {
  law_.surfaces.clear();
  listed_.addTo(law_.surfaces, topology_, *this);
  obstacles_.addTo(law_);
  law_.surfaces.finish();
  mean_edge_ = law_.surfaces.meanEdge();
  if (law_.range == 0) law_.range = partOfMeanEdge(law_.surfaces, 0.1);
  law_.surfaces.giveWidth(law_.range, law_.thickness);
  law_.candidates.self_contact = self_;
  outputs_.compile(law_, bodies_);
}

std::string ContactField::choice() const {
  std::string text = fmt::format("{}, which push below a gap of {:.4g} m with a stiffness of {:.4g} Pa", namesOf(law_, bodies_, self_),
                                 law_.range, law_.stiffness);
  if (friction_.mu_static > friction_.mu) text += fmt::format(", static friction {:g}", friction_.mu_static);
  if (friction_.acts()) text += fmt::format(", friction {:g}", friction_.mu);
  if (law_.adhesion.strength > 0) text += fmt::format(", adhesion {:.4g} Pa", law_.adhesion.strength);
  return text;
}

/// Of a term in the caches; its sixteen blocks look for their places. Never nothing, which would be a field whose cost is not known.
ForceField::Cost ContactField::cost() const {
  const double terms = 1 + double(terms_.size() + friction_.terms().size());
  return {50 * terms, 800 * terms};
}

double ContactField::solvePotential(ConstRows x) const {
  gather(x, law_.moved);
  return friction_.energy(x_, start_, law_.moved - moved_at_start_);
}

void ContactField::addStiffnessProduct(ConstRows dx, double factor, Rows df) const {
  terms_.addProduct(dx, factor, df);
  friction_.terms().addProduct(dx, factor, df);
}

void ContactField::addStiffness(double factor, BlockMatrix& matrix) const {
  terms_.addTo(factor, matrix);
  friction_.terms().addTo(factor, matrix);
}

void ContactField::addStiffnessDiagonal(double factor, std::vector<double>& blocks) const {
  terms_.addDiagonal(factor, blocks);
  friction_.terms().addDiagonal(factor, blocks);
}

}  // namespace stroma::contact
