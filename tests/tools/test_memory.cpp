// SPDX-License-Identifier: LGPL-2.1-or-later
// A scene that asks for more memory than a process may have, and how often a run waits for the kernel to give it memory.
#include <sys/resource.h>

#include <cstdio>
#include <fstream>
#include <string>

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

/// A larger body touches 29 MB more: 7,300 small pages.
TEST_F(MemoryOfTheCommand, IsTakenInHugePagesWhereTheKernelGivesThem) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer has an allocator of its own";
#endif
  std::string given;
  std::getline(std::ifstream("/sys/kernel/mm/transparent_hugepage/enabled"), given);
  if (given.empty() || given.find("[never]") != std::string::npos) GTEST_SKIP() << "the kernel gives none";
  const auto faults = [&](const std::string& n) {
    write("body.xml",
          "<Node name='root' gravity='0 -9.81 0' dt='1'>\n  <StaticSolver/>\n  <SparseLDLSolver/>\n"
          "  <RegularGridTopology name='grid' n='" + n + "' min='0 0 0' max='0.1 0.1 0.1'/>\n  <MechanicalObject/>\n"
          "  <DiagonalMass massDensity='1000'/>\n  <HexahedronFEMForceField youngModulus='1e5' poissonRatio='0.3' method='small'/>\n"
          "  <BoxROI name='wall' box='-1 -1 -1 0.0001 1 1'/>\n  <FixedProjectiveConstraint indices='@wall.indices'/>\n</Node>\n");
    rusage before{}, after{};
    getrusage(RUSAGE_CHILDREN, &before);
    const Finished run = shell("'" STROMA_COMMAND "' run body.xml -n 1 --threads 1 --no-record");
    getrusage(RUSAGE_CHILDREN, &after);
    EXPECT_EQ(run.code, 0) << run.err;
    return after.ru_minflt - before.ru_minflt;
  };
  const long few = faults("3 3 3"), many = faults("15 15 15");
  EXPECT_LT(many - few, 2500);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
