// SPDX-License-Identifier: LGPL-2.1-or-later
// Where a body bursts, every field with a rest shape says which element did.
#include <algorithm>
#include <limits>

#include "framework/simulation/system_report.h"
#include "tests/support/field_under_test.h"
#include "tests/support/force_field_examples.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Nodes of the field's state whose place it feels: those with a force when moved alone.
std::vector<Index> feltRows(FieldUnderTest& t) {
  std::vector<Index> felt;
  const State& state = t.field().state();
  t.rest();
  const Vector before = t.force();
  for (Index i = 0; i < state.size(); ++i) {
    if (state.kindOf(i) != RowKind::place) continue;
    t.rest();
    t.x[state.firstRow() + i] += Vec3(0.01, 0.02, 0.03);
    if (relativeDifference(t.force(), before) > 1e-9) felt.push_back(state.firstRow() + i);
  }
  return felt;
}

TEST(WorstElement, IsNamedByEveryFieldWithARestShape) {
  // whose forces need no balance, and that have no shape
  const std::string others[] = {"BeamHookeLawForceField", "FrameSpringForceField", "JointSpringForceField", "PolynomialSpringsForceField"};
  modules().openAll();
  int fields = 0;
  for (const ComponentEntry* entry : factory().entries()) {
    if (entry->module.empty() || !dynamic_cast<ForceField*>(factory().make(entry->type).get())) continue;
    const std::string example = exampleOf(entry->type), type = fieldOf(example, entry->type);
    if (type.empty()) continue;
    SCOPED_TRACE(entry->type);
    FieldUnderTest t(example, type);
    const ForceTraits traits = t.field().traits();
    const std::vector<Index> felt = feltRows(t);
    const bool ties_alone = std::ranges::find(others, entry->type) != std::end(others);
    if (felt.empty() || !(traits.has_rest_shape || traits.forces_balance || ties_alone)) continue;
    ++fields;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const Vec3& to : {Vec3(1e3, -2e3, 1e3), Vec3(nan, nan, nan)}) {
      t.rest();
      t.x[felt.back()] = to;
      copy(t.x, t.system().x);
      const std::string worst = ties_alone ? whereAndWhy(t.system(), {}, "", "") : worstElementOf(t.field(), t.system(), t.x);
      EXPECT_NE(worst.find("node"), std::string::npos) << to.transpose() << ": '" << worst << "'";
    }
  }
  EXPECT_GT(fields, 36);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
