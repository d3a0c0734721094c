// SPDX-License-Identifier: LGPL-2.1-or-later
// Components that ask for more memory than there is.
#include <cstdio>
#include <new>

#include "tests/scene/test_components.h"

namespace stroma::testing {
namespace STROMA_TEST_FILE {

/// Wants what nobody has.
class Greedy : public Component {
 public:
  void declare(DataTable& table) override { table.add("position", position_).help("points").unit("m").output(); }
  void init() override { throw std::bad_alloc(); }
  std::string roleText() const override { return "mesh"; }

 private:
  std::vector<Vec3> position_;
};

class Memory : public SceneTest {
 protected:
  Memory() { factory.add<Greedy>("Greedy", "wants what nobody has"); }
};

TEST_F(Memory, AComponentThatGetsNoneIsNamedWithItsPlace) {
  const Problem problem = problemOf("<Node>\n  <TestMesh position='1 0 0'/>\n  <Greedy name='mesh'/>\n</Node>");
  EXPECT_EQ(problem.path, "/mesh");
  EXPECT_EQ(problem.where.line, 3);
  double megabytes = 0;
  EXPECT_EQ(std::sscanf(problem.message.c_str(), "it needs more than %lf MB of memory", &megabytes), 1) << problem.text();
  EXPECT_GT(megabytes, 1) << "what this machine has left";
  EXPECT_EQ(problem.message.find("bad_alloc"), std::string::npos) << problem.text();
}

TEST_F(Memory, WhatNeedsSuchAComponentAddsNoSentence) {
  const std::vector<Problem> problems = problemsOf("<Node><Greedy name='mesh'/><TestState position='@mesh.position'/></Node>");
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_EQ(problems[0].path, "/mesh");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::testing
