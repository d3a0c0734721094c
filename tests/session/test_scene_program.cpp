// SPDX-License-Identifier: LGPL-2.1-or-later
// A scene that is a program, here one of C++: it is asked for its description, told of steps and keys, and ends the run by what
// it throws.
#include "tools/session/scene_program.h"

#include <gtest/gtest.h>

#include "framework/mechanics/state.h"
#include "framework/scene/load.h"
#include "tools/session/session.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr const char* falling = R"(<Node name="root" gravity="0 0 -10" dt="0.1"><EulerExplicitSolver/>
  <MechanicalObject name="dofs" position="0 0 0"/><UniformMass totalMass="1"/></Node>)";

struct Told {
  std::vector<std::string> all;
  double fails_at = 1e9;  ///< time of the step before which it fails
};

class Player : public SceneProgram {
 public:
  explicit Player(Told& told) : told_(told) {}
  SceneDescription describe(const std::string& file, Session&) override {
    told_.all.push_back("describe " + file);
    Diagnostics diagnostics;
    SceneDescription scene;
    scene.root = readXml(falling, file, {}, diagnostics);
    scene.file = file;
    return scene;
  }
  void loaded(Session& session) override {
    told_.all.push_back("loaded");
    EXPECT_TRUE(session.isLoaded());
  }
  void beforeStep(Simulation& simulation) override {
    told_.all.push_back("before");
    EXPECT_FALSE(simulation.isStepping());
    if (simulation.time() > told_.fails_at) throw ProgramError("scene.py:3: it fails");
  }
  void afterStep(Simulation& simulation) override {
    told_.all.push_back("after");
    EXPECT_FALSE(simulation.isStepping());
  }
  void key(const std::string& name, bool pressed) override { told_.all.push_back(name + (pressed ? " down" : " up")); }

 private:
  Told& told_;
};

class Programs : public testing::Test {
 protected:
  void SetUp() override { setSceneProgram(std::make_unique<Player>(told_)); }
  void TearDown() override { setSceneProgram(nullptr); }
  Told told_;
  Session session_;
};

TEST_F(Programs, TakePartInSteps) {
  const Simulation& simulation = session_.load("scene.py");
  EXPECT_TRUE(session_.isProgram());
  RunLimits limits;
  limits.steps = 2;
  EXPECT_EQ(session_.run(limits).end, RunEnd::done);
  session_.key("ArrowUp", true);
  session_.step();
  const std::vector<std::string> expected = {"describe scene.py", "loaded", "before", "after", "before",
                                             "after", "ArrowUp down", "before", "after"};
  EXPECT_EQ(told_.all, expected);
  EXPECT_EQ(simulation.steps(), 3);
  EXPECT_NEAR(simulation.states().at(0)->x()[0].z(), -10 * 0.01 * 6, 1e-12) << "x = -g h^2 n (n + 1) / 2";
}

TEST_F(Programs, EndARunByWhatTheyThrow) {
  session_.load("scene.py");
  told_.fails_at = 0.15;
  RunLimits limits;
  limits.steps = 5;
  const RunReport report = session_.run(limits);
  EXPECT_EQ(report.end, RunEnd::program_failed);
  EXPECT_EQ(report.reason, "scene.py:3: it fails");
  EXPECT_EQ(session_.simulation().steps(), 2) << "the step that it came before was not made";
}

TEST_F(Programs, HaveNoPartInOtherScenes) {
  session_.load("scene.py", {{"/", "dt", "0.2"}});
  EXPECT_EQ(session_.simulation().dt(), 0.2) << "overrides are those of any scene";
  session_.loadText(falling, "scene.xml");
  EXPECT_FALSE(session_.isProgram());
  told_.all.clear();
  session_.step();
  session_.key("a", true);
  EXPECT_TRUE(told_.all.empty());
}

TEST(SceneProgram, NobodyPlaysIt) {
  Session session;
  EXPECT_TRUE(isSceneProgram("folder/scene.py"));
  EXPECT_FALSE(isSceneProgram("scene.xml"));
  EXPECT_THROW(session.load("scene.py"), ProgramError);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
