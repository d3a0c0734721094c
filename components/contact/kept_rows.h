// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/contact/kept_gaps.h"
#include "framework/mechanics/lagrangian_constraint.h"

namespace stroma::contact {

/// The conditions of gaps at x, where they were last evaluated: one `push` per gap, two `rub` with `friction`, and at the end one that no
/// force can satisfy if the step is not proved: -(unproved + reported) [m].
void addRows(const KeptGaps& gaps, const BarrierLaw& law, const std::vector<Vec3>& x, double friction, double reported,
             LagrangianRows& rows);

}  // namespace stroma::contact
