// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_attributes.h"

#include <fmt/format.h>

#include "framework/scene/data.h"
#include "framework/scene/diagnostics.h"

namespace stroma::contact {
namespace {

/// What staticFriction is until a scene writes it: a zero that is written means zero.
constexpr double not_given = -1;

}  // namespace

void declareFriction(DataTable& table, Friction& friction) {
  table.add("friction", friction.mu).help("Coulomb's coefficient mu of sliding contacts").unit("-").min(0);
  table.add("staticFriction", friction.mu_static).help("that of what sticks; not given: friction").unit("-").min(0);
  friction.mu_static = not_given;
}

void finishFriction(Friction& friction) {
  if (friction.mu_static == not_given) friction.mu_static = friction.mu;
  if (friction.mu_static < friction.mu)
    throw ComponentError(fmt::format("staticFriction is {:g} and friction {:g}", friction.mu_static, friction.mu),
                         "a staticFriction that is not smaller than friction");
}

void declareAdhesion(DataTable& table, Adhesion& adhesion, Friction& friction) {
  table.add("adhesion", adhesion.strength).help("largest tension between adhering surfaces").unit("Pa").min(0);
  table.add("adhesionPeak", adhesion.peak).help("gap at which adhesion is largest; 0: contactDistance").unit("m").min(0);
  table.add("adhesionDistance", adhesion.range).help("gap at which adhesion ends; 0: twice adhesionPeak").unit("m").min(0);
  table.add("adhesionFriction", friction.mu_adhesion)
      .help("what adhesion bears along surfaces that stick, over its tension")
      .unit("-")
      .min(0);
}

void finishAdhesion(Adhesion& adhesion, const Friction& friction, double range) {
  if (adhesion.strength == 0) {
    if (adhesion.peak > 0 || adhesion.range > 0 || friction.mu_adhesion > 0)
      throw ComponentError("adhesion is zero, and attributes of it are given", "adhesion=\"...\" in pascal");
    return;
  }
  if (adhesion.peak == 0) adhesion.peak = range;
  if (adhesion.range == 0) adhesion.range = 2 * adhesion.peak;
  if (adhesion.peak < range)
    throw ComponentError(fmt::format("adhesionPeak is {:g} m and contactDistance {:g} m", adhesion.peak, range),
                         "an adhesionPeak of contactDistance or more, where nothing pushes");
  if (!(adhesion.range > adhesion.peak))
    throw ComponentError(fmt::format("adhesionDistance is {:g} m and adhesionPeak {:g} m", adhesion.range, adhesion.peak),
                         "an adhesionDistance that is larger");
}

}  // namespace stroma::contact
