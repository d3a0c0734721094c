// SPDX-License-Identifier: LGPL-2.1-or-later
// Precomputations tell how far they are, of whatever form. What is made of it: tests/tools.
#include <algorithm>

#include "framework/simulation/long_work.h"
#include "tests/condensation/bodies.h"

using namespace stroma;
using namespace stroma::test;

namespace {

struct Told {
  std::string what;
  double operations = 0;
  std::vector<double> shares;
};

class Listener final : public LongWorkListener {
 public:
  explicit Listener(Told& told) : told_(told) {}
  void say(double share) override { told_.shares.push_back(share); }
  void advise(const std::string&) override {}

 private:
  Told& told_;
};

/// What the load of a scene tells.
std::vector<Told> toldBy(const std::string& scene) {
  std::vector<Told> all;
  all.reserve(10);  // listeners keep their place
  listenToLongWork([&all](const std::string& what, double operations) {
    return std::make_unique<Listener>(all.emplace_back(Told{what, operations, {}}));
  });
  simulationFromText(scene);
  listenToLongWork({});
  return all;
}

}  // namespace

TEST(LongWork, OfPrecomputationsIsToldFromNothingToAll) {
  // of 140 nodes 20 are held; of the others 90 lie on the surface
  struct Case {
    const char *solver, *what;
    double least_operations;  ///< of what is dense, n^3
  };
  const Case cases[] = {{"CondensedStaticSolver", ": 90 kept nodes over 30", 270.0 * 270 * 270},
                        {"CondensedDynamicSolver", ": 90 kept nodes over 30", 270.0 * 270 * 270},
                        {"CondensedDynamicSolver condensed=\"false\" solve=\"factor\"", ": the factor of 120 nodes", 1e5}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.solver);
    const std::vector<Told> all = toldBy(Block{.solver = "<" + std::string(c.solver) + " name=\"solver\"/>"}.text());
    ASSERT_EQ(all.size(), 1u);
    EXPECT_EQ(all[0].what, "/solver" + std::string(c.what));
    EXPECT_GT(all[0].operations, c.least_operations);
    const std::vector<double>& shares = all[0].shares;
    ASSERT_GT(shares.size(), 3u);
    EXPECT_EQ(shares.front(), 0);
    EXPECT_NEAR(shares.back(), 1, 1e-12);
    EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
    const auto is_between = [](double share) { return share > 0.1 && share < 0.9; };
    EXPECT_GT(std::count_if(shares.begin(), shares.end(), is_between), 0) << "nothing is told on the way";
  }
}
