// SPDX-License-Identifier: LGPL-2.1-or-later
// Files of precomputed arrays, and the condensed solvers that use them: damaged, foreign, cut and half-written ones.
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <fstream>
#include <functional>
#include <sstream>

#include "components/condensation/condensed_integrator.h"
#include "components/condensation/section_file.h"
#include "tests/condensation/bodies.h"

using namespace stroma;
using namespace stroma::test;
namespace fs = std::filesystem;

namespace {

class CacheFolder : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("stroma_cache_" + std::to_string(getpid()));
    fs::remove_all(folder);
  }
  void TearDown() override { fs::remove_all(folder); }

  std::string scene(const std::string& solver = "Static", const std::string& young = "5000") const {
    Block block{.solver = "<Condensed" + solver + "Solver cacheFolder=\"" + folder.string() + "\"/>",
                .loads = "<ConstantForceField indices=\"139 47\" totalForce=\"0.05 0.02 -0.03\"/>"};
    block.young = young;
    return block.text();
  }
  /// The one file of the folder.
  fs::path file() const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(folder)) found.push_back(entry.path());
    EXPECT_EQ(found.size(), 1u);
    return found.front();
  }
  static bool fromCache(const Simulation& simulation) {
    return *std::get<bool*>(simulation.systems().front()->integrator().data().find("fromCache")->pointer());
  }
  void flip(std::uintmax_t at) const {
    std::fstream stream(file(), std::ios::in | std::ios::out | std::ios::binary);
    stream.seekg(std::streamoff(at));
    const char byte = char(stream.get());
    stream.seekp(std::streamoff(at));
    stream.put(char(byte ^ 0x10));
  }
  /// In the numbers of the factor of the inside of scene(). They end three padded sections, a page of times and one of
  /// check sums before the end of the file.
  void flipFactor() const {
    const auto pages = [](std::size_t bytes) { return (bytes + 4095) / 4096 * 4096; };
    const std::size_t free = 120, kept = 90;
    flip(fs::file_size(file()) - 2 * pages(free * 24) - pages((3 * kept + 7) / 8 * 64) - 2 * 4096 - 5000);
  }
  static std::uint64_t hashAfterSteps(Simulation& simulation) {
    for (int i = 0; i < 3; ++i) simulation.step();
    return simulation.stateHash();
  }

  fs::path folder;
};

}  // namespace

TEST_F(CacheFolder, SecondRunTakesTheSameNumbersFromTheFile) {
  for (const std::string solver : {"Static", "Dynamic"}) {
    Simulation first = simulationFromText(scene(solver)), second = simulationFromText(scene(solver));
    EXPECT_FALSE(fromCache(first));
    EXPECT_TRUE(fromCache(second));
    EXPECT_EQ(hashAfterSteps(first), hashAfterSteps(second));
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 2);
}

TEST_F(CacheFolder, AFileSaysWhetherWholeBodiesHaveAnInverse) {
  int forms = 0;
  for (const std::string choice : {"", "precision=\"single\"", "solve=\"inverse\"", "solve=\"factor\""}) {
    const std::string text =
        scene("Dynamic").replace(scene("Dynamic").find("Solver ") + 7, 0, "condensed=\"false\" " + choice + " ");
    Simulation first = simulationFromText(text), second = simulationFromText(text);
    EXPECT_FALSE(fromCache(first)) << choice;
    EXPECT_TRUE(fromCache(second)) << choice;
    const std::string plan = first.systems().front()->integrator().describe();
    EXPECT_EQ(second.systems().front()->integrator().describe().substr(0, plan.size()), plan);
    EXPECT_EQ(hashAfterSteps(first), hashAfterSteps(second)) << choice;
    forms |= plan.find("sparse factor") == std::string::npos ? 1 : 2;
  }
  EXPECT_EQ(forms, 3);
}

TEST_F(CacheFolder, AnotherMaterialIsAnotherFile) {
  Simulation first = simulationFromText(scene()), second = simulationFromText(scene("Static", "5001"));
  EXPECT_FALSE(fromCache(second));
  EXPECT_NE(hashAfterSteps(first), hashAfterSteps(second));
}

TEST_F(CacheFolder, OtherMassesAreAnotherFileThoughTheMatrixIsTheSame) {
  // k + m/dt^2 = 5200 N/m for both
  const auto oscillator = [&](const std::string& spring, const std::string& mass, bool cached) {
    return simulationFromText(
        "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><CondensedDynamicSolver condensed=\"false\" "
        "solve=\"inverse\" "
        "cacheFolder=\"" +
        (cached ? folder.string() : "") +
        "\"/><MechanicalObject position=\"1.3 0 0\" rest_position=\"1 0 0\"/><UniformMass totalMass=\"" + mass +
        "\"/><RestShapeSpringsForceField points=\"0\" stiffness=\"" + spring + "\"/></Node>");
  };
  for (const auto& [spring, mass] : {std::pair("200", "0.5"), std::pair("1200", "0.4")}) {
    Simulation cached = oscillator(spring, mass, true), plain = oscillator(spring, mass, false);
    EXPECT_FALSE(fromCache(cached));
    EXPECT_EQ(hashAfterSteps(cached), hashAfterSteps(plain)) << spring;
  }
}

TEST(CondensedSources, TheirDigestIsThatOfTheFiles) {
  // those that make the numbers of a file, by another program
  const std::string command =
      "cd '" STROMA_SOURCE_DIR
      "' && LC_ALL=C; export LC_ALL; sha256sum $(ls components/condensation/*.h components/condensation/*.cpp "
      "components/elasticity/*.h components/elasticity/*.cpp components/mechanics/*.h "
      "components/mechanics/*.cpp components/springs/*.cpp framework/fem/* "
      "framework/algebra/block_matrix.* | sort) | cut -c1-64 | tr -d '\\n' | sha256sum";
  std::FILE* pipe = popen(command.c_str(), "r");
  ASSERT_TRUE(pipe);
  std::string digest(64, ' ');
  EXPECT_EQ(std::fread(digest.data(), 1, 64, pipe), 64u);
  pclose(pipe);
  EXPECT_EQ(CondensedIntegrator::sourcesOfNumbers(), digest);
}

TEST_F(CacheFolder, WithoutAHomeNothingIsKeptAndThatIsSaid) {
  fs::create_directories(folder);
  const fs::path here = fs::current_path();
  const char* home = std::getenv("HOME");
  const std::string before = home ? home : "";
  unsetenv("HOME"), unsetenv("XDG_CACHE_HOME");
  fs::current_path(folder);
  testing::internal::CaptureStderr();
  const Simulation simulation =
      simulationFromText(Block{.solver = "<CondensedStaticSolver cacheFolder=\"auto\"/>"}.text());
  const std::string said = testing::internal::GetCapturedStderr();
  fs::current_path(here);
  if (home) setenv("HOME", before.c_str(), 1);
  EXPECT_NE(said.find("nothing is cached"), std::string::npos) << said;
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST_F(CacheFolder, WhatIsWrongWithAFileIsSaidAndItIsMadeAnew) {
  const auto wholeSize = [&] { return fs::file_size(file()); };
  const std::string text = scene("Dynamic");  // reads all of it
  Simulation first = simulationFromText(text);
  const std::uint64_t expected = hashAfterSteps(first);
  const std::vector<std::pair<std::function<void()>, std::string>> harms{
      {[&] { flip(5000); }, "numbers are damaged"},
      {[&] { flip(20); }, "header is damaged"},
      {[&] { flip(2); }, "no such file"},
      {[&] { flip(8); }, "another format"},
      {[&] { flip(wholeSize() - 4096); }, "check sums are damaged"},
      {[&] { fs::resize_file(file(), wholeSize() - 4096); }, "cut short"},
      {[&] { fs::resize_file(file(), 100); }, "too short"}};
  for (const auto& [harm, sentence] : harms) {
    harm();
    testing::internal::CaptureStderr();
    Simulation again = simulationFromText(text);
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_FALSE(fromCache(again)) << sentence;
    EXPECT_NE(said.find(sentence), std::string::npos) << said;
    EXPECT_EQ(hashAfterSteps(again), expected);
    Simulation mended = simulationFromText(text);
    EXPECT_TRUE(fromCache(mended)) << sentence;
  }
}

TEST_F(CacheFolder, EveryChoiceHasItsOwnNumbers) {
  for (const std::string choice :
       {"Static", "Static condensed=false", "Static precision=single", "Dynamic", "Dynamic interiorMass=shared",
        "Dynamic interiorMass=neglected", "Dynamic interiorMass=neglected precision=single",
        "Dynamic condensed=false solve=inverse", "Dynamic condensed=false solve=factor"}) {
    SCOPED_TRACE(choice);
    const std::string solver = choice.substr(0, choice.find(' '));
    std::istringstream stream(choice.substr(solver.size()));
    std::string attributes;
    for (std::string word; stream >> word;) attributes += word.insert(word.find('=') + 1, "\"") + "\" ";
    const auto run = [&](bool cached) {
      Block block{.solver = "<Condensed" + solver + "Solver " + attributes +
                            (cached ? "cacheFolder=\"" + folder.string() + "\"" : "") + "/>",
                  .loads = "<ConstantForceField indices=\"139 47\" totalForce=\"0.05 0.02 -0.03\"/>"};
      Simulation simulation = simulationFromText(block.text());
      return std::pair(hashAfterSteps(simulation), fromCache(simulation));
    };
    const std::uint64_t plain = run(false).first;
    EXPECT_EQ(run(true), std::pair(plain, false));
    EXPECT_EQ(run(true), std::pair(plain, true));
  }
}

TEST_F(CacheFolder, ABodyWithoutKeptNodesHasAFileToo) {
  std::string held;
  for (int n = 0; n < 64; ++n)
    if (n % 4 % 3 == 0 || n / 4 % 4 % 3 == 0 || n / 16 % 3 == 0) held += std::to_string(n) + " ";
  const std::string text =
      "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 -9.81\"><CondensedStaticSolver cacheFolder=\"" + folder.string() +
      "\"/><RegularGridTopology n=\"4 4 4\" min=\"0 0 0\" max=\"1 1 1\"/><MechanicalObject/><UniformMass "
      "totalMass=\"1\"/><HexahedronFEMForceField method=\"small\" youngModulus=\"5000\" poissonRatio=\"0.3\"/>"
      "<FixedProjectiveConstraint indices=\"" +
      held + "\"/></Node>";
  Simulation first = simulationFromText(text), second = simulationFromText(text);
  EXPECT_TRUE(fromCache(second));
  EXPECT_EQ(hashAfterSteps(first), hashAfterSteps(second));
}

/// A static body reads the columns of nodes whose loads change, and no others.
TEST_F(CacheFolder, DamageIsFoundInWhatIsRead) {
  Block block{.solver = "<CondensedStaticSolver cacheFolder=\"" + folder.string() + "\"/>",
              .loads = "<LinearForceField points=\"139\" keyTimes=\"0 1\" forces=\"0 0 0  1 0.5 0\"/>"};
  Simulation first = simulationFromText(block.text());
  const std::uint64_t expected = hashAfterSteps(first);
  const std::uintmax_t kept = 90, inverse = kept * 3 * 8 * ((3 * kept + 7) / 8) * 8, checked = std::uintmax_t(1) << 18;
  int found = 0, unread = 0;
  for (std::uintmax_t at = 100; at < inverse; at += checked) {
    flip(4096 + at);
    Simulation again = simulationFromText(block.text());
    EXPECT_EQ(hashAfterSteps(again), expected) << at;
    ++(fromCache(again) ? unread : found);
    if (fromCache(again)) flip(4096 + at);
  }
  EXPECT_GE(found, 1);
  EXPECT_GE(unread, 1);
}

TEST_F(CacheFolder, TheFileOfAnotherBodyIsNotTaken) {
  simulationFromText(scene());
  const fs::path mine = file();
  const fs::path kept = folder.string() + "_kept";
  fs::rename(mine, kept);
  simulationFromText(scene("Static", "7000"));
  fs::rename(file(), mine);
  testing::internal::CaptureStderr();
  Simulation again = simulationFromText(scene());
  EXPECT_NE(testing::internal::GetCapturedStderr().find("of something else"), std::string::npos);
  EXPECT_FALSE(fromCache(again));
  fs::remove(kept);
}

TEST_F(CacheFolder, ADamagedFactorOfTheInsideIsMadeAnewWhenItIsNeeded) {
  Simulation first = simulationFromText(scene());
  const std::uint64_t expected = hashAfterSteps(first);
  flipFactor();
  Simulation again = simulationFromText(scene());
  EXPECT_TRUE(fromCache(again));
  testing::internal::CaptureStderr();
  EXPECT_EQ(hashAfterSteps(again), expected);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("factor of the interior"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder) && std::distance(fs::directory_iterator(folder), {}) > 0);
}

TEST_F(CacheFolder, AFactorThatIsMadeAnewMustFitIntoMemoryToo) {
  simulationFromText(scene());
  flipFactor();
  std::string text = scene();
  text.replace(text.find("cacheFolder"), 0, "memoryLimit=\"0.0001\" ");
  Simulation again = simulationFromText(text);
  EXPECT_TRUE(fromCache(again));
  try {
    again.step();
    ADD_FAILURE() << "nothing was refused";
  } catch (const ComponentError& error) {
    const std::string said = error.what();
    for (const std::string words : {"the factor of the interior", "allowed by memoryLimit"})
      EXPECT_NE(said.find(words), std::string::npos) << said;
  }
  // what the file has of worth stays; without it a run starts from the beginning, with the refusal of every start
  EXPECT_TRUE(fromCache(simulationFromText(text)));
  fs::remove_all(folder);
  EXPECT_NE(problemsOf(text).find("allowed by memoryLimit"), std::string::npos);
}

TEST_F(CacheFolder, RunsAtOnceLeaveOneWholeFile) {
  std::vector<pid_t> runs;
  for (int i = 0; i < 4; ++i) {
    const pid_t child = fork();
    if (child == 0) {
      Simulation simulation = simulationFromText(scene());
      _exit(hashAfterSteps(simulation) == 0);
    }
    runs.push_back(child);
  }
  for (const pid_t run : runs) {
    int status = 1;
    waitpid(run, &status, 0);
    EXPECT_EQ(status, 0);
  }
  file();
  const Simulation later = simulationFromText(scene());
  EXPECT_TRUE(fromCache(later));
}

TEST_F(CacheFolder, AFolderThatCannotBeWrittenIsAWarning) {
  fs::create_directories(folder);
  std::ofstream(folder / "file").put('x');
  const Block block{.solver = "<CondensedStaticSolver cacheFolder=\"" + (folder / "file" / "sub").string() + "\"/>"};
  testing::internal::CaptureStderr();
  after(block.text(), 1);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("cannot be written"), std::string::npos);
}

namespace {

/// As where files cannot be without a name.
std::string writeNamed(const fs::path& path, const std::vector<char>& data) {
  return SectionFile::write(path.string(), ContentKey(), {{data.data(), data.size()}}, false);
}

/// A process that stopped in the middle of writing `path`, whoever runs first: its files may not grow beyond half of what
/// it writes, and at that limit it stops.
pid_t writerStoppedHalfWay(const fs::path& path, bool nameless) {
  const std::vector<char> zeros(std::size_t(1) << 22);
  const pid_t child = fork();
  if (child == 0) {
    const rlimit half{zeros.size() / 2, zeros.size() / 2};
    std::signal(SIGXFSZ, [](int) { raise(SIGSTOP); });
    if (setrlimit(RLIMIT_FSIZE, &half) == 0)
      SectionFile::write(path.string(), ContentKey(), {{zeros.data(), zeros.size()}}, nameless);
    _exit(1);
  }
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, WUNTRACED), child);
  EXPECT_TRUE(WIFSTOPPED(status)) << "the writer ended before its file was half written";
  return child;
}

void killed(pid_t child) {
  kill(child, SIGKILL);
  EXPECT_EQ(waitpid(child, nullptr, 0), child);
}

}  // namespace

TEST_F(CacheFolder, AHalfWrittenFileIsNeverSeen) {
  fs::create_directories(folder);
  killed(writerStoppedHalfWay(folder / "x.sections", true));
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST_F(CacheFolder, WhatAKilledRunLeavesIsNeverTakenAndRemovedByTheNext) {
  fs::create_directories(folder);
  const fs::path path = folder / "x.sections", half = folder / "y.sections";
  const pid_t child = writerStoppedHalfWay(half, false);
  const auto files = [&] { return std::distance(fs::directory_iterator(folder), {}); };
  EXPECT_EQ(files(), 1);
  EXPECT_FALSE(fs::exists(half));
  const std::vector<char> few(1000, 'x');
  EXPECT_EQ(writeNamed(path, few), "");
  EXPECT_EQ(files(), 2) << "a file belongs to its writer as long as that lives";
  killed(child);
  SectionFile found;
  std::string reason;
  EXPECT_FALSE(found.open(half.string(), ContentKey(), 1, reason));
  EXPECT_EQ(reason, "");
  EXPECT_EQ(writeNamed(path, few), "");
  EXPECT_EQ(file(), path);
  EXPECT_TRUE(found.open(path.string(), ContentKey(), 1, reason)) << reason;
}

TEST_F(CacheFolder, RunsThatWriteAtOnceWithNamesLeaveOneWholeFile) {
  const fs::path path = folder / "x.sections";
  const std::vector<char> data(std::size_t(1) << 20, 'x');
  std::vector<pid_t> runs;
  for (int i = 0; i < 4; ++i) {
    const pid_t child = fork();
    if (child == 0) {
      int refused = 0;
      for (int k = 0; k < 20; ++k) refused += !writeNamed(path, data).empty();
      _exit(refused);
    }
    runs.push_back(child);
  }
  for (const pid_t run : runs) {
    int status = 1;
    waitpid(run, &status, 0);
    EXPECT_EQ(status, 0);
  }
  EXPECT_EQ(file(), path);
  SectionFile found;
  std::string reason;
  EXPECT_TRUE(found.open(path.string(), ContentKey(), 1, reason) && found.isIntact(0)) << reason;
}

TEST_F(CacheFolder, OtherFilesOfTheFolderAreLeftAlone) {
  fs::create_directories(folder);
  for (const std::string name : {"x.sections.old", "x.sections.1", "notes.1.2", "z.sections.1.2.3"})
    std::ofstream(folder / name).put('x');
  std::ofstream(folder / "z.sections.1.2").put('x');
  EXPECT_EQ(writeNamed(folder / "x.sections", std::vector<char>(10)), "");
  EXPECT_FALSE(fs::exists(folder / "z.sections.1.2"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 5);
}
