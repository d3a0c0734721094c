// SPDX-License-Identifier: LGPL-2.1-or-later
// A scene that asks for more memory than a process may have.
#include <cstdio>

#include "tests/support/shell.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

class MemoryOfTheCommand : public CommandTest {};

TEST_F(MemoryOfTheCommand, AMeshThatIsTooLargeIsRefusedAsOtherBadInput) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer takes more address space than a limit leaves";
#endif
  write("large.xml",
        "<Node name='root'>\n  <EulerExplicitSolver/>\n  <RegularGridTopology name='grid' n='500 500 500'/>\n"
        "  <MechanicalObject/>\n  <UniformMass totalMass='1'/>\n</Node>\n");
  const Finished run = shell("(ulimit -v 2000000; '" STROMA_COMMAND "' run large.xml -n 1 --threads 1)");
  EXPECT_EQ(run.code, 2) << run.err;
  EXPECT_NE(run.err.find("large.xml:3"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("/grid"), std::string::npos) << run.err;
  const std::size_t said = run.err.find("it asks for more than ");
  ASSERT_NE(said, std::string::npos) << run.err;
  double megabytes = 0;
  ASSERT_EQ(std::sscanf(run.err.c_str() + said, "it asks for more than %lf MB of memory", &megabytes), 1) << run.err;
  EXPECT_GT(megabytes, 100) << "125 million nodes take 3000";
  EXPECT_LT(megabytes, 2000000 * 1024. / 1048576);
  EXPECT_NE(run.err.find("nothing was run"), std::string::npos) << run.err;
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
