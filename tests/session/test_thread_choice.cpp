// SPDX-License-Identifier: LGPL-2.1-or-later
// How many threads a run takes when nobody gives a number, and that no bit depends on it.
#include "tools/session/thread_choice.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <limits>

#include "framework/algebra/parallel.h"
#include "tests/support/folder_fixture.h"
#include "tools/session/processors.h"
#include "tools/session/session.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

namespace fs = std::filesystem;

const std::string explicit_steps = "<EulerExplicitSolver/>", implicit = "<EulerImplicitSolver/>";

/// A bar of tetrahedra or hexahedra, held at one end.
std::string bar(int along, int across, const std::string& integrator, const std::string& solver, const std::string& law = {},
                bool is_cut = true) {
  const std::string n = std::to_string(along) + " " + std::to_string(across) + " " + std::to_string(across);
  const std::string field = !law.empty() ? law : R"(<TetrahedronFEMForceField method="polar" youngModulus="1e6" poissonRatio="0.4"/>)";
  const std::string cells = is_cut ? R"(<TetrahedronSetTopologyContainer name="tets"/>
    <Hexa2TetraTopologicalMapping input="@../grid" output="@tets" cutting="five"/>)" : "";
  const std::string dt = integrator == explicit_steps ? "0.0001" : "0.01";
  return "<Node name=\"root\" dt=\"" + dt + R"(" gravity="0 -9.81 0"><RegularGridTopology name="grid" n=")" + n +
         R"(" min="0 0 0" max="0.4 0.2 0.2"/>)" + integrator + solver +
         R"(<MechanicalObject name="dofs"/><UniformMass totalMass="16"/>
  <BoxROI name="wall" box="-0.001 -1 -1  0.001 1 1" position="@dofs.rest_position"/><FixedProjectiveConstraint indices="@wall.indices"/>
  <Node name="cells">)" + cells + field + "</Node></Node>";
}
const std::string fixed = R"(<CGLinearSolver iterations="5" tolerance="1e-30"/>)";

int tasks() {
  const fs::directory_iterator folder("/proc/self/task");
  return int(std::distance(begin(folder), end(folder)));
}

/// Threads are chosen, whatever the caller's environment says.
class ThreadChoice : public FolderTest {
 protected:
  ThreadChoice() {
    if (const char* text = std::getenv("STROMA_THREADS")) before_ = text;
    unsetenv("STROMA_THREADS");
    chooseThreads(true);
  }
  ~ThreadChoice() override {
    chooseThreads(false);
    if (!before_.empty()) setenv("STROMA_THREADS", before_.c_str(), 1);
  }
  std::string before_;
};

TEST(ThreadModel, EachThreadHasItsNodes) {
  EXPECT_EQ(threadsThatPay(0, 16), 1);
  EXPECT_EQ(threadsThatPay(2 * nodes_per_thread - 1, 16), 1);
  EXPECT_EQ(threadsThatPay(2 * nodes_per_thread, 16), 2);
  EXPECT_EQ(threadsThatPay(2 * nodes_per_thread, 1), 1);
  EXPECT_EQ(threadsThatPay(5 * nodes_per_thread, 16), 5);
  EXPECT_EQ(threadsThatPay(1000 * nodes_per_thread, 64), 64);
}

TEST_F(ThreadChoice, ASmallSceneStartsNoThread) {
  setThreads(1);
  Session session;
  for (const char* solver : {"<SparseLDLSolver/>", ""}) {
    session.loadText(bar(21, 11, implicit, solver), "small.xml");
    const int before = tasks();
    session.run({.steps = 3});
    EXPECT_EQ(threads(), 1);
    EXPECT_EQ(tasks(), before);
  }
}

TEST_F(ThreadChoice, ALargeSceneHasTheCoresAndAnotherSessionDoesNotTakeThem) {
  const int several = std::min(2, usableCores());
  Session large, small;
  const Simulation& simulation = large.loadText(bar(33, 17, implicit, fixed), "large.xml");
  EXPECT_EQ(threads(), several);
  EXPECT_NE(threadsText(simulation).find("9537 independent nodes"), std::string::npos) << threadsText(simulation);
  small.loadText(bar(5, 3, implicit, fixed), "small.xml");
  EXPECT_EQ(threads(), 1);
  small.step();
  EXPECT_EQ(threads(), 1);
  large.step();
  EXPECT_EQ(threads(), several);
  EXPECT_TRUE(chooseThreads(false)) << "they were chosen";
  large.step();
  EXPECT_EQ(threads(), 1) << "runs at once have one thread each";
}

TEST_F(ThreadChoice, QuotasOfControlGroups) {
  const auto group = [this](const std::string& path, const std::string& file, const std::string& text) {
    fs::create_directories(folder_ / path);
    std::ofstream(folder_ / path / file) << text << '\n';
  };
  const auto quota = [this](const std::string& groups) { return processorQuota(groups, folder_); };
  const double none = std::numeric_limits<double>::infinity();
  EXPECT_EQ(quota(""), none);
  EXPECT_EQ(quota("0::/"), none);
  group("pod", "cpu.max", "150000 100000");
  group("pod/task", "cpu.max", "max 100000");
  EXPECT_EQ(quota("0::/pod/task"), 1.5) << "of the group around it";
  group("pod/task", "cpu.max", "50000 100000");
  EXPECT_EQ(quota("0::/pod/task\n"), 0.5);
  EXPECT_EQ(quota("0::/other"), none);
  group("", "cpu.max", "400000 100000");
  EXPECT_EQ(quota("0::/of/another/container"), 4) << "only the container's own folder is seen";
  group("cpu,cpuacct/box", "cpu.cfs_quota_us", "300000");
  group("cpu,cpuacct/box", "cpu.cfs_period_us", "100000");
  EXPECT_EQ(quota("4:cpu,cpuacct:/box"), 3);
  EXPECT_EQ(quota("5:cpuset:/box"), none);
  group("cpu,cpuacct/box", "cpu.cfs_quota_us", "-1");
  EXPECT_EQ(quota("4:cpu,cpuacct:/box"), none);
  EXPECT_GE(usableCores(), 1);
}

// ---- the same bits with 1, 2, 16 and 64 threads: a scene of each family of solvers, with enough nodes for several threads ----

struct SolverFamily {
  const char* name;
  std::string scene;
  int steps = 1;
};
const std::string neo_hookean =
    R"(<TetrahedronHyperelasticityFEMForceField materialName="NeoHookean" youngModulus="1e6" poissonRatio="0.45"/>)";
const std::string boxes = R"(<HexahedronFEMForceField topology="@../grid" method="polar" youngModulus="1e6" poissonRatio="0.4"/>)";
std::string pcg(const std::string& attributes) { return "<PCGLinearSolver " + attributes + "/>"; }

const SolverFamily families[] = {
    {"explicit steps", bar(33, 17, explicit_steps, ""), 3},
    {"statics, nothing named", bar(33, 17, "<StaticSolver/>", "")},
    {"hexahedra, nothing named", bar(33, 17, implicit, "", boxes, false), 3},
    {"conjugate gradients", bar(33, 17, implicit, R"(<CGLinearSolver iterations="30"/>)", neo_hookean), 2},
    {"assembled", bar(33, 17, implicit, pcg(R"(preconditioner="block_jacobi" template="CompressedRowSparseMatrix")"))},
    {"incomplete factors", bar(33, 17, implicit, pcg(R"(preconditioner="incomplete_cholesky")"))},
    {"multigrid", bar(33, 17, implicit, pcg(R"(preconditioner="multigrid")"))},
    {"minimal residuals", bar(33, 17, implicit, R"(<MinResLinearSolver iterations="20"/>)")},
    {"factors", bar(33, 17, implicit, R"(<SparseLDLSolver precision="single"/>)")},
    {"factors in double precision", bar(33, 17, implicit, R"(<SparseLDLSolver precision="double"/>)")},
};

TEST(BitsOfThreads, DoNotDependOnTheirNumber) {
  for (const SolverFamily& family : families) {
    std::uint64_t first = 0, start = 0;
    for (const int count : {1, 2, 16, 64}) {
      setThreads(count);
      Session session;
      Simulation& simulation = session.loadText(family.scene, "bar.xml");
      start = simulation.stateHash();
      ASSERT_EQ(session.run({.steps = family.steps}).end, RunEnd::done) << family.name;
      if (count == 1) first = simulation.stateHash();
      EXPECT_EQ(simulation.stateHash(), first) << family.name << ", " << count << " threads";
    }
    EXPECT_NE(first, start) << family.name;
  }
  setThreads(1);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
