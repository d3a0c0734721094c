// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/contact/kept_gaps.h"
#include "framework/mechanics/lagrangian_constraint.h"

namespace stroma::contact {

/// The conditions of gaps where they were last looked at, x: of each a push, with `friction` two that rub, and of all one that no
/// force mends: below zero by what is unproved and `reported` [m], or by half of that where bodies only graze each other on their way.
void addRows(const KeptGaps& gaps, const BarrierLaw& law, const std::vector<Vec3>& x, double friction, double reported,
             LagrangianRows& rows);

}  // namespace stroma::contact
