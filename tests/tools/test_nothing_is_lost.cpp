// SPDX-License-Identifier: LGPL-2.1-or-later
// Files that a run reads are not written over, and an output that fails takes no other with it.
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "framework/simulation/state_file.h"
#include "tests/support/shell.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

namespace fs = std::filesystem;

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

class NothingIsLost : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write("body.msh", block);
    write("start.state", "T= 0\n  X= 0 0 0 1 0 0 0 1 0 0 0 1\n");
  }
  /// A falling tetrahedron of the mesh, line 5 on: `observers`.
  void writeScene(const std::string& observers) const {
    write("fall.xml", R"(<Node name="root" dt="0.01" gravity="0 -10 0"><EulerExplicitSolver/>
  <MeshGmshLoader name="mesh" filename="body.msh"/><TetrahedronSetTopologyContainer src="@mesh"/>
  <MechanicalObject name="dofs"/><UniformMass totalMass="2"/><ReadState filename="start.state"/>
  <!-- -->
)" + observers + "\n</Node>\n");
  }
  /// Of the whole folder, but for what the shell writes.
  std::map<std::string, std::string> contents() const {
    std::map<std::string, std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(folder_))
      if (entry.is_regular_file() && !entry.path().filename().string().starts_with("."))
        all[entry.path().string()] = readText(entry.path());
    return all;
  }
  Finished shell(const std::string& line) const {
    const int status = std::system(("cd '" + folder_.string() + "' && { " + line + "; } >.out 2>.err").c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, readText(folder_ / ".out"), readText(folder_ / ".err")};
  }

  /// A loop of the shell that ends when `condition` holds, or after ten minutes: nothing takes so long but a hang.
  static std::string waitFor(const std::string& condition) {
    return "for try in $(seq 60000); do " + condition + " && break; sleep 0.01; done; ";
  }
  /// The same until a run has written some instants to a state file: it is in the middle of its steps.
  static std::string waitForSteps(const std::string& file) {
    return waitFor("[ \"$(grep -c T= " + file + " 2>/dev/null)\" -gt 3 ] 2>/dev/null");
  }

  static constexpr const char* block =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n$Elements\n1\n"
      "1 4 0 1 2 3 4\n$EndElements\n";
};

TEST_F(NothingIsLost, NoOutputOverwritesWhatTheRunReads) {
  fs::create_symlink("body.msh", folder_ / "link.msh");
  fs::create_hard_link(folder_ / "start.state", folder_ / "same.state");
  fs::create_directory_symlink(".", folder_ / "here");
  write("beam00003.vtu", "read by nobody");
  struct Case {
    std::string observers, options, expected;
  };
  const std::vector<Case> cases = {
      {"<WriteState filename='body.msh'/>", "", "fall.xml:5:1: error: /WriteState: /WriteState would overwrite"},
      {"<WriteState filename='here/../link.msh'/>", "", "which /mesh reads"},
      {"<WriteState filename='here/link.msh'/>", "", "which /mesh reads"},
      {"<WriteState filename='same.state'/>", "", "which /ReadState reads"},
      {"<EnergyMonitor filename='fall.xml'/>", "", "which the scene reads"},
      {"<Monitor indices='0' fileName='body' ExportPositions='1'/>", "--set /mesh.filename=body_x.txt",
       "body_x.txt, which /mesh reads"},
      {"<VTKExporter filename='body'/>", "--set /mesh.filename=body00003.vtu", "body00003.vtu, which /mesh reads"},
      {"<WriteState name='a' filename='out.txt'/><EnergyMonitor name='b' filename='here/out.txt'/>", "",
       "/a and /b would both write"},
      {"<WriteState filename='out/dofs.state.gz'/>", "--record out", "/WriteState and --record would both write"},
      {"", "--json=fall.xml", "--json would overwrite fall.xml, which the scene reads"},
      {"", "--json=out/last.checkpoint --record out", "--record and --json would both write"},
      {"", "--record here --set /ReadState.filename=dofs.state.gz", "--record would overwrite"},
      {"", "--set /ReadState.filename=results/fall/last/run.instants", "what the run leaves to be looked at"},
      {"<WriteState filename='results/fall/last/last.checkpoint'/>", "",
       "would both write results/fall/last/last.checkpoint"},
  };
  fs::copy(folder_ / "body.msh", folder_ / "body_x.txt");
  fs::copy(folder_ / "body.msh", folder_ / "body00003.vtu");
  fs::copy(folder_ / "start.state", folder_ / "dofs.state.gz");
  fs::create_directories(folder_ / "results/fall/last");
  fs::copy(folder_ / "start.state", folder_ / "results/fall/last/run.instants");
  for (const auto& [observers, options, expected] : cases) {
    writeScene(observers);
    const auto before = contents();
    const Finished run = stroma("run fall.xml -n 2 --quiet " + options);
    EXPECT_EQ(run.code, 2) << observers << options << run.err;
    EXPECT_TRUE(has(run.err, expected)) << expected << "\n" << run.err;
    EXPECT_TRUE(contents() == before) << observers << options;
  }
}

TEST_F(NothingIsLost, AMeshIsNotWrittenOverItsSurface) {
  write("body.stl", "solid block\nendsolid block\n");
  fs::remove(folder_ / "body.msh");
  fs::create_symlink("body.stl", folder_ / "body.msh");
  write("list", "refs\nfall.xml 2 1e-9\n");
  writeScene("");
  const auto before = contents();
  const Finished mesh = stroma("mesh body.stl -o ./body.msh"), regress = stroma("regress list --json list");
  for (const Finished* run : {&mesh, &regress}) {
    EXPECT_EQ(run->code, 2) << run->err;
    EXPECT_TRUE(has(run->err, "would overwrite")) << run->err;
  }
  EXPECT_TRUE(contents() == before);
}

/// Missing, read-only and full places are found before any file is touched, with the system's reason.
TEST_F(NothingIsLost, WhatCannotBeWrittenIsFoundBeforeTheFirstStep) {
  write("file", "");
  fs::create_directory(folder_ / "folder");
  const std::pair<std::string, std::string> places[] = {{"file/x", "Not a directory"},
                                                        {"/proc/none/x", "No such file or directory"},
                                                        {"/dev/full", "No space left on device"}};
  struct Writer {
    std::string before, after, options;
  };
  const std::vector<Writer> writers = {{"<WriteState filename='", "'/>", ""},
                                       {"<EnergyMonitor filename='", "'/>", ""},
                                       {"<Monitor indices='0' ExportForces='1' fileName='", "'/>", ""},
                                       {"<VTKExporter filename='", "'/>", ""},
                                       {"", "", "--json="},
                                       {"", "", "--record "}};
  write("first.state", "kept");
  for (const auto& [place, reason] : places)
    for (const Writer& writer : writers) {
      const bool is_device = place == "/dev/full";
      if (is_device && !has(writer.before, "WriteState") && !has(writer.before, "EnergyMonitor")) continue;
      const bool by_option = !writer.options.empty();
      writeScene("<WriteState filename='first.state'/>" + (by_option ? "" : writer.before + place + writer.after));
      const auto before = contents();
      const Finished run = stroma("run fall.xml -n 2 --quiet " + (by_option ? writer.options + place : ""));
      EXPECT_EQ(run.code, 2) << place << writer.before << writer.options << run.err;
      EXPECT_TRUE(has(run.err, reason)) << run.err;
      EXPECT_TRUE(has(run.err, is_device ? place : fs::path(place).parent_path().string())) << run.err;
      EXPECT_TRUE(is_device || contents() == before) << place << writer.before << writer.options;
    }
}

/// A limit on the size of files stops the largest first, as a disk does that fills up.
TEST_F(NothingIsLost, AnOutputThatFailsEndsTheRunAndTheOthersAreWhole) {
  const std::vector<std::string> failing = {
      "<WriteState name='big' filename='big.state' writeV='1' writeX0='1' writeF='1'/>",
      "<Monitor name='big' indices='0 1 2 3 0 1 2 3 0 1 2 3' ExportPositions='1'/>"};
  for (const std::string& big : failing) {
    writeScene(big +
               "<EnergyMonitor filename='energy.txt' exportEveryNumberOfSteps='10'/>"
               "<WriteState filename='small.state' period='0.1'/>");
    const Finished run = shell("ulimit -f 16; '" STROMA_COMMAND
                               "' run fall.xml -n 1000 --quiet --record out --record-every 10 --json=end.json");
    EXPECT_EQ(run.code, 4) << run.err;
    EXPECT_TRUE(has(run.err, "big") && has(run.err, "cannot write (File too large)")) << run.err;
    const auto json = nlohmann::json::parse(readText(folder_ / "end.json"));
    EXPECT_EQ(json["outcome"], "ended by an output");
    const long steps = json["steps"];
    EXPECT_GT(steps, 10);
    EXPECT_LT(steps, 1000);
    const auto expected = std::size_t(steps / 10 + 1);
    EXPECT_EQ(readStateFile(file("small.state")).size(), expected);
    EXPECT_GE(readStateFile(file("out/dofs.state.gz")).size(), expected);
    const std::string energy = readText(folder_ / "energy.txt");
    EXPECT_EQ(std::size_t(std::count(energy.begin(), energy.end(), '\n')), expected + 1);
    if (exists("big.state")) {
      const StateRecording recording = readRecording(file("big.state"));
      EXPECT_EQ(recording.frames.size(), std::size_t(steps)) << "all but the one that did not fit";
      EXPECT_TRUE(has(recording.unfinished, "not finished"));
    }
    for (const char* name : {"out", "big.state"}) fs::remove_all(folder_ / name);
  }
}

TEST_F(NothingIsLost, APlaceThatGoesAwayEndsTheRunAndTheOthersAreWhole) {
  struct Case {
    std::string observer, option, removal;
  };
  const Case cases[] = {{"<WriteState name='a' filename='gone/a.state'/>", "", "rm -r gone"},
                        {"<EnergyMonitor name='a' filename='gone/a.txt'/>", "", "rm -r gone"},
                        {"<Monitor name='a' indices='0' ExportForces='1' fileName='gone/a'/>", "", "rm -r gone"},
                        {"<VTKExporter name='a' filename='gone/a'/>", "", "mv gone away"},
                        {"", "--record gone --record-every 10", "rm -r gone"}};
  for (const auto& [observer, option, removal] : cases) {
    writeScene("<WriteState name='kept' filename='kept.state' period='1'/>" + observer);
    const Finished run = shell("{ " + waitForSteps("kept.state") + removal +
                               "; } & timeout 600 '" STROMA_COMMAND "' run fall.xml -n 1000000000 --quiet " + option);
    EXPECT_EQ(run.code, 4) << observer << option << run.err;
    EXPECT_TRUE(has(run.err, "gone/") && has(run.err, "No such file or directory")) << run.err;
    EXPECT_GE(readStateFile(file("kept.state")).size(), 1u) << observer << option;
    for (const char* name : {"gone", "away", "kept.state"}) fs::remove_all(folder_ / name);
  }
}

/// The disk of the pictures fills up; the recording on another one is whole.
TEST_F(NothingIsLost, AFullDiskUnderThePicturesKeepsTheRecording) {
  fs::create_directory(folder_ / "full");
  if (shell("mount -t tmpfs -o size=48k none full").code != 0) GTEST_SKIP() << "only root may mount a small disk";
  writeScene("<VTKExporter filename='full/body'/>");
  const Finished run = stroma("run fall.xml -n 500 --quiet --record out");
  const Finished again = stroma("run fall.xml -n 500 --quiet --record out2");
  shell("umount full");
  EXPECT_EQ(run.code, 4) << run.err;
  EXPECT_TRUE(has(run.err, "full/body") && has(run.err, "No space left on device")) << run.err;
  EXPECT_GT(readStateFile(file("out/dofs.state.gz")).size(), 2u);
  EXPECT_EQ(again.code, 2) << "a disk that is full at the start is found there: " << again.err;
  EXPECT_TRUE(has(again.err, "No space left on device")) << again.err;
  EXPECT_FALSE(exists("out2/dofs.state.gz"));
}

TEST_F(NothingIsLost, AReadOnlyDiskIsFoundBeforeTheFirstStep) {
  fs::create_directory(folder_ / "disk");
  if (shell("mount -t tmpfs -o size=48k none disk && mount -o remount,ro disk").code != 0)
    GTEST_SKIP() << "only root may mount a disk";
  write("first.state", "kept");
  writeScene("<WriteState filename='first.state'/><VTKExporter filename='disk/body'/>");
  const Finished run = stroma("run fall.xml -n 5 --quiet");
  shell("umount disk");
  EXPECT_EQ(run.code, 2) << run.err;
  EXPECT_TRUE(has(run.err, "disk/body") && has(run.err, "Read-only file system")) << run.err;
  EXPECT_EQ(readText(folder_ / "first.state"), "kept");
}

/// SIGTERM ends a run as Ctrl-C does; the same command with --resume goes on as if it had not.
TEST_F(NothingIsLost, ARunThatIsEndedGoesOn) {
  writeScene("<WriteState filename='all.state'/>");
  for (const auto& [signal, code] : {std::pair("TERM", 143), std::pair("INT", 130)}) {
    const std::string command = "'" STROMA_COMMAND "' run fall.xml --quiet --record out --record-every 7 --resume ";
    const Finished run = shell(command + "-n 1000000000 & pid=$!; " + waitForSteps("all.state") + "kill -" + signal +
                               " $pid; wait $pid");
    EXPECT_EQ(run.code, code) << run.err;
    EXPECT_EQ(readRecording(file("out/dofs.state.gz")).unfinished, "");
    const auto steps = long(readStateFile(file("all.state")).size()) - 1;
    ASSERT_TRUE(exists("out/last.checkpoint"));
    const std::string n = std::to_string(std::max(steps, 4000L));
    const Finished on = stroma("run fall.xml --quiet --record out --record-every 7 --resume -n " + n);
    EXPECT_EQ(on.code, 0) << on.err;
    ASSERT_EQ(stroma("run fall.xml -n " + n + " --quiet --record whole --record-every 7").code, 0);
    EXPECT_TRUE(readText(folder_ / "out/dofs.state.gz") == readText(folder_ / "whole/dofs.state.gz")) << steps;
    for (const char* name : {"out", "all.state"}) fs::remove_all(folder_ / name);
  }
}

/// Of a static step that takes many times as long as the test waits, by a factorisation that no library call interrupts:
/// the first signal gives the step up, and what was recorded before it is whole and goes on.
TEST_F(NothingIsLost, ALongStepIsGivenUp) {
  const auto scene = [](const std::string& nodes) {
    return R"(<Node name="root" dt="1" gravity="0 -9.81 0"><StaticSolver/><SparseLDLSolver/>
  <RegularGridTopology name="grid" n=")" + nodes + R"(" min="0 0 0" max="0.1 0.1 0.1"/>
  <MechanicalObject name="dofs" position="@grid.position"/><UniformMass totalMass="1"/>
  <HexahedronFEMForceField youngModulus="4000" poissonRatio="0.4" method="svd" tangent="exact"/>
  <BoxROI name="end" box="-1 -0.001 -1  1 0.001 1"/><FixedProjectiveConstraint indices="@end.indices"/></Node>)";
  };
  // a fifth of a second of processor time after the recording began, so that it is the factorisation that is met
  const std::string ticks = "$(cut -d' ' -f14 /proc/$pid/stat 2>/dev/null || echo ",
                    calculates_on = "until_tick=$((" + ticks + "0) + 20)); " + waitFor("[ " + ticks + "1000000) -ge $until_tick ]");
  for (const auto& [signals, code] : {std::pair("kill -TERM $pid", 143), std::pair("kill -INT $pid", 130),
                                      std::pair("kill -INT $pid; kill -INT $pid", 130)}) {
    Finished run;
    for (const char* nodes : {"21 21 21", "31 31 31"}) {  // more where the step is over before the signal
      fs::remove_all(folder_ / "out");
      write("long.xml", scene(nodes));
      run = shell("'" STROMA_COMMAND "' run long.xml -n 1 --quiet --record out & pid=$!; " +
                  waitFor("[ -s out/dofs.state.gz ]") + calculates_on + std::string(signals) + "; wait $pid");
      if (run.code != 0) break;
    }
    EXPECT_EQ(run.code, code) << run.err;
    if (std::string(signals).find(';') == std::string::npos) {
      EXPECT_EQ(readRecording(file("out/dofs.state.gz")).unfinished, "");
      EXPECT_EQ(readStateFile(file("out/dofs.state.gz")).size(), 1u) << "of a step that was given up there is nothing";
      ASSERT_TRUE(exists("out/last.checkpoint"));
      EXPECT_EQ(stroma("run long.xml -n 0 --quiet --record out --resume").code, 0);
    }
    fs::remove_all(folder_ / "out");
  }
}

TEST_F(NothingIsLost, ARunFromTheStartDoesNotLeaveTheCheckpointOfTheOneBefore) {
  writeScene("");
  ASSERT_EQ(stroma("run fall.xml -n 5 --quiet --record out").code, 0);
  const Finished run = shell("'" STROMA_COMMAND
                             "' run fall.xml -n 1000000000 --quiet --record out --record-every 1000000 "
                             "--checkpoint-seconds 0 & pid=$!; " +
                             waitFor("[ ! -e out/last.checkpoint ]") + "kill -KILL $pid; wait $pid");
  EXPECT_EQ(run.code, 137);
  EXPECT_FALSE(exists("out/last.checkpoint"));
  EXPECT_TRUE(has(stroma("run fall.xml --resume").err, "--resume needs --record"));
  EXPECT_TRUE(has(stroma("run fall.xml --record a --resume --restart b").err, "exclude each other"));
  EXPECT_TRUE(has(stroma("run fall.xml --record a --checkpoint-seconds -1").err, "expected 0 or more"));
}

/// -n counts the steps of the whole run, which may all be made.
TEST_F(NothingIsLost, ACheckpointBeyondTheLastStepIsSaid) {
  writeScene("");
  ASSERT_EQ(stroma("run fall.xml -n 20 --record out").code, 0);
  const std::string sentence = "note: the checkpoint is that of step 20: up to step 10 there is nothing to do";
  const Finished run = stroma("run fall.xml -n 10 --record out --resume");
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_TRUE(has(run.err, sentence)) << run.err;
  EXPECT_FALSE(has(stroma("run fall.xml -n 20 --record out --resume").err, "nothing to do"));
}

/// A state from before a failed step is called good only when most of its elements are.
TEST_F(NothingIsLost, TheLastStateOfADivergedRunSaysHowGoodItIs) {
  const auto scene = [](const char* tip) {
    return std::string(
               "<Node name='root' dt='0.01' gravity='0 0 0'><EulerExplicitSolver/>"
               "<MeshTopology position='0 0 0  1 0 0  0 1 0  0 0 1' tetrahedra='0 1 2 3'/>"
               "<MechanicalObject name='dofs' rest_position='0 0 0  1 0 0  0 1 0  0 0 1' position='0 0 0  1 0 0  0 1 0 "
               " 0 0 ") +
           tip +
           "'/><UniformMass totalMass='1'/><MeshSpringForceField stiffness='100'/>"
           "<ConstantForceField indices='0' forces='1e308 0 0'/></Node>";
  };
  write("good.xml", scene("1"));
  write("bad.xml", scene("-1"));
  const Finished good = stroma("run good.xml --set /.dt=10 --quiet"),
                 bad = stroma("run bad.xml --set /.dt=10 --quiet --json");
  EXPECT_EQ(good.code, 3) << good.err;
  EXPECT_TRUE(has(good.err, "the last good state (t = 0, 0 of 1 elements inverted) is in results/good/last/"))
      << good.err;
  EXPECT_EQ(bad.code, 3) << bad.err;
  EXPECT_TRUE(has(bad.err, "the last state (t = 0, 1 of 1 elements inverted: no good one) is in results/bad/last/"))
      << bad.err;
  EXPECT_EQ(nlohmann::json::parse(bad.out).at("inverted_elements").at("inverted"), 1);
}

/// A link to a file would put the output in that file's place, whatever it is: every writer refuses it alike.
TEST_F(NothingIsLost, NoOutputGoesThroughALinkToAFile) {
  write("notes.txt", "kept");
  for (const char* link : {"out.png", "out.txt", "out.msh", "out.json"})
    fs::create_symlink("notes.txt", folder_ / link);
  writeScene("");
  std::vector<std::string> commands = {"picture fall.xml -n 0 -o out.png", "run fall.xml -n 1 --json=out.json"};
  for (const std::string& line : commands) {
    const Finished run = stroma(line);
    EXPECT_NE(run.code, 0) << line;
    EXPECT_TRUE(has(run.err, "is a symbolic link to notes.txt, which would be overwritten")) << line << run.err;
  }
  writeScene("<WriteState filename='out.txt'/>");
  const Finished run = stroma("run fall.xml -n 1");
  EXPECT_EQ(run.code, 2);
  EXPECT_TRUE(has(run.err, "is a symbolic link")) << run.err;
  EXPECT_EQ(readText(folder_ / "notes.txt"), "kept");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
