// SPDX-License-Identifier: LGPL-2.1-or-later
// A regression test is worth what it notices: every way in which a reference can differ must fail.
#include <tinyxml2.h>

#include <nlohmann/json.hpp>

#include "framework/simulation/state_file.h"
#include "tests/support/shell.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

namespace fs = std::filesystem;

class Regress : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write("fall.xml", falling_scene);
    write("list", "# falling stones\nreferences\nfall.xml 8 1e-9\n");
    ASSERT_EQ(stroma("regress list --update").code, 0);
  }
  std::string reference() const { return (folder_ / "references/fall/stone.dofs.state.gz").string(); }

  /// Replaces the reference by what `change` makes of it.
  template <class Change>
  void tamper(Change change) const {
    auto frames = readStateFile(reference());
    change(frames);
    StateWriter writer(reference());
    for (const StateFrame& frame : frames) {
      writer.time(frame.time);
      writer.rows("X", frame.x);
      writer.rows("V", frame.v);
    }
    writer.close();
  }
  /// Expects failure with `text` in what is said.
  void expectFailure(const std::string& text) const {
    const Finished run = stroma("regress list");
    EXPECT_EQ(run.code, 1) << run.out << run.err;
    EXPECT_NE(run.out.find("FAILED"), std::string::npos) << run.out;
    EXPECT_NE(run.out.find(text), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("0 passed, 1 failed"), std::string::npos) << run.out;
  }
};

using Frames = std::vector<StateFrame>;

TEST_F(Regress, PassesOnItsOwnReferences) {
  const Finished run = stroma("regress list --json figures.json");
  EXPECT_EQ(run.code, 0) << run.out << run.err;
  EXPECT_NE(run.out.find("1 passed, 0 failed"), std::string::npos);
  const auto json = nlohmann::json::parse(readText(folder_ / "figures.json"));
  EXPECT_EQ(json.at(0).at("states").at("stone.dofs.state.gz").at("position_error"), 0);
  const auto frames = readStateFile(reference());
  ASSERT_EQ(frames.size(), 5u);
  EXPECT_NEAR(frames.back().time, 0.08, 1e-15) << "the last step is compared";
}

TEST_F(Regress, NoticesANumberThatIsNotFinite) {
  tamper([](Frames& frames) { frames[2].x[1].y() = std::nan(""); });
  expectFailure("node 1 at t = 0.04 s is not finite");
  tamper([](Frames& frames) { frames[2].x[1].y() = 0, frames[1].v[0].z() = HUGE_VAL; });
  expectFailure("node 0 at t = 0.02 s is not finite");
}

TEST_F(Regress, NoticesADifferenceAtTheLastInstantOnly) {
  tamper([](Frames& frames) { frames.back().x[1].x() += 1e-7; });
  expectFailure("position differs");
}

TEST_F(Regress, NoticesAVelocity) {
  tamper([](Frames& frames) { frames.back().v[0].x() += 1e-5; });
  expectFailure("velocity differs");
}

TEST_F(Regress, NoticesPermutedNodes) {
  tamper([](Frames& frames) {
    for (StateFrame& frame : frames) std::swap(frame.x[0], frame.x[1]), std::swap(frame.v[0], frame.v[1]);
  });
  expectFailure("position differs");
}

TEST_F(Regress, NoticesAnotherSizeTimeOrNumberOfInstants) {
  tamper([](Frames& frames) {
    for (StateFrame& frame : frames) frame.x.pop_back(), frame.v.pop_back();
  });
  expectFailure("2 positions and 2 velocities, in the reference 1 and 1");
  stroma("regress list --update");
  tamper([](Frames& frames) { frames[3].time += 1e-4; });
  expectFailure("instant 3 is at t = ");
  stroma("regress list --update");
  tamper([](Frames& frames) { frames.pop_back(); });
  expectFailure("5 frames, the reference has 4");
}

TEST_F(Regress, NoticesATruncatedReference) {
  fs::resize_file(reference(), fs::file_size(reference()) - 20);
  expectFailure("cut short");
  fs::resize_file(reference(), 0);
  expectFailure("holds no instant");
}

TEST_F(Regress, NoticesMissingAndSuperfluousReferences) {
  fs::copy(reference(), folder_ / "references/fall/ghost.state.gz");
  expectFailure("no state for the reference");
  fs::remove(folder_ / "references/fall/ghost.state.gz");
  fs::remove(reference());
  expectFailure("there is no reference");
  fs::remove_all(folder_ / "references");
  expectFailure("there is no reference");
}

TEST_F(Regress, ASceneThatDoesNotLoadOrDivergesFails) {
  write("fall.xml", "<Node name=\"root\"><Nonsense/></Node>\n");
  expectFailure("does not load");
}

TEST_F(Regress, OverridesMakeCasesOfTheirOwn) {
  write("list", "references\nfall.xml 8 1e-9\nfall.xml 8 1e-9 /stone/dofs.velocity=0,0,0,0,1,0\n");
  Finished run = stroma("regress list");
  EXPECT_EQ(run.code, 1) << "the new case has no reference";
  write("list", "references\nfall.xml 8 1e-9\nfall.xml 4 1e-9 /.dt=0.02\n");
  EXPECT_EQ(stroma("regress list --update --filter dt").code, 0);
  run = stroma("regress list");
  EXPECT_EQ(run.code, 0) << run.out;
  EXPECT_NE(run.out.find("2 passed, 0 failed"), std::string::npos) << run.out;
}

TEST_F(Regress, AListThatCannotBeReadIsBadInput) {
  const std::pair<const char*, const char*> cases[] = {
      {"references\nfall.xml 8\n", "list:2: expected SCENE STEPS TOLERANCE"},
      {"references\nfall.xml 8 nan\n", "list:2: expected SCENE STEPS TOLERANCE"},
      {"references\nfall.xml 8 1e-9 1\n", "list:2: '1' is not PATH.ATTR=VALUE"},
      {"references\nfall.xml 8 1e-9\nfall.xml 9 1e-9\n", "list:3: the same scene and overrides"},
      {"references\n", "no scene is listed"},
  };
  for (const auto& [text, expected] : cases) {
    write("list", text);
    const Finished run = stroma("regress list");
    EXPECT_EQ(run.code, 2);
    EXPECT_NE(run.err.find(expected), std::string::npos) << run.err;
  }
  EXPECT_EQ(stroma("regress absent").code, 2);
  write("list", "references\nfall.xml 8 1e-9\n");
  EXPECT_EQ(stroma("regress list --filter nothing").code, 2);
  EXPECT_EQ(stroma("regress list --set nonsense").code, 2);
  EXPECT_EQ(stroma("regress list --update --set /.dt=0.02").code, 2);
}

TEST_F(Regress, WritesJunitForBuildServers) {
  write("list", "references\nfall.xml 8 1e-9\nfall.xml 4 1e-9 /.gravity=\"<&>\"\n");
  EXPECT_EQ(stroma("regress list --junit results.xml").code, 1);
  tinyxml2::XMLDocument document;
  ASSERT_EQ(document.LoadFile((folder_ / "results.xml").c_str()), tinyxml2::XML_SUCCESS);
  const tinyxml2::XMLElement* suite = document.FirstChildElement("testsuite");
  ASSERT_NE(suite, nullptr);
  EXPECT_EQ(suite->IntAttribute("tests"), 2);
  EXPECT_EQ(suite->IntAttribute("failures"), 1);
  const tinyxml2::XMLElement* good = suite->FirstChildElement("testcase");
  ASSERT_NE(good, nullptr);
  EXPECT_STREQ(good->Attribute("name"), "fall");
  EXPECT_EQ(good->FirstChildElement(), nullptr);
  const tinyxml2::XMLElement* bad = good->NextSiblingElement("testcase");
  ASSERT_NE(bad, nullptr);
  ASSERT_NE(bad->FirstChildElement("failure"), nullptr);
  EXPECT_NE(std::string(bad->FirstChildElement("failure")->GetText()).find("gravity"), std::string::npos);
  EXPECT_EQ(stroma("regress list --filter nothing --junit other.xml").code, 2);
  EXPECT_FALSE(exists("other.xml"));
}

// ---- bits ----

TEST_F(Regress, StoresAndComparesTheBitsOfTheLastState) {
  Finished run = stroma("regress list --bits");
  EXPECT_EQ(run.code, 0) << run.out << run.err;
  EXPECT_NE(run.out.find("none is stored"), std::string::npos) << run.out;
  EXPECT_EQ(stroma("regress list --bits --update").code, 0);
  run = stroma("regress list --bits");
  EXPECT_EQ(run.code, 0) << run.out << run.err;
  EXPECT_NE(run.out.find("as stored"), std::string::npos) << run.out;
  const std::string hash = nlohmann::json::parse(stroma("run fall.xml -n 8 --json").out).at("state_hash");
  EXPECT_NE(readText(folder_ / "references/hashes").find(hash), std::string::npos);

  // one bit of one number
  std::string scene = readText(folder_ / "fall.xml");
  scene.replace(scene.find("0 2 0"), 5, "0 2.0000000000000004 0");
  write("fall.xml", scene);
  run = stroma("regress list --bits");
  EXPECT_EQ(run.code, 1);
  EXPECT_NE(run.out.find("its bits have changed"), std::string::npos) << run.out;
}

TEST_F(Regress, HashesOfAnotherBuildAreNotCompared) {
  write("list", "references\nfall.xml 8 1e-9 bits=processor\n");
  EXPECT_EQ(stroma("regress list").code, 0) << "the name of the case is the same";
  EXPECT_NE(stroma("regress list --bits --update").out.find("not stored"), std::string::npos);
  write("list", "references\nfall.xml 8 1e-9\n");
  write("references/hashes", "build gcc-1.0-Release\nfall x86-64-v2 0123456789abcdef\n");
  const Finished run = stroma("regress list --bits");
  EXPECT_EQ(run.code, 0) << run.out << run.err;
  EXPECT_NE(run.out.find("stored are those of gcc-1.0-Release"), std::string::npos) << run.out;
  write("references/hashes", "build gcc-1.0-Release\nfall x86-64-v2 123\n");
  EXPECT_EQ(stroma("regress list --bits").code, 2);
}

TEST_F(Regress, NoticesBitsThatDependOnThreadsOrOnFormerRuns) {
  std::string scene = falling_scene;
  const std::string mass = "<UniformMass totalMass=\"2\"/>";
  scene.insert(scene.find(mass) + mass.size(), "<FickleForceField name=\"odd\" what=\"calls\"/>");
  write("fickle.xml", scene);
  write("list", "references\nfickle.xml 8 1e-9\n");
  const std::string command = "regress list --bits --module '" STROMA_TEST_MODULES "/fickle.so'";
  Finished run = stroma(command);
  EXPECT_EQ(run.code, 1) << run.err;
  EXPECT_NE(run.out.find("the run after a reset differs from step 1 on"), std::string::npos) << run.out;
  run = stroma(command + " --set /stone/odd.what=threads");
  EXPECT_EQ(run.code, 1) << run.err;
  EXPECT_NE(run.out.find("the run with two threads differs from step 1 on"), std::string::npos) << run.out;
}

TEST_F(Regress, AnAnswerOfSolvesThatStoppedShortIsStoredOnlyWhenTheListSaysSo) {
  write("chain.xml", capped_chain);
  write("short", "references\nchain.xml 4 1e-6\n");
  const Finished refused = stroma("regress short --update");
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.out.find("stopped before its tolerance in 3 of 4 steps"), std::string::npos) << refused.out;
  EXPECT_FALSE(fs::exists(folder_ / "references/chain"));
  write("short", "references\nchain.xml 4 1e-6 unconverged\n");
  EXPECT_EQ(stroma("regress short --update").code, 0);
  EXPECT_EQ(stroma("regress short").code, 0);
}

TEST_F(Regress, AToleranceThatLetsEverythingPassIsRefused) {
  for (const char* tolerance : {"1e9", "1"}) {
    write("list", fmt::format("references\nfall.xml 8 {}\n", tolerance));
    const Finished run = stroma("regress list");
    EXPECT_EQ(run.code, 2);
    EXPECT_NE(run.err.find("lets every state pass"), std::string::npos) << run.err;
  }
}

TEST_F(Regress, ComparesEnergiesAndAttributesWithTheirOwnTolerance) {
  write("list", "references\nfall.xml 8 1e-9 data=kinetic_energy:1e-6 data=/stone/UniformMass.totalMass\n");
  ASSERT_EQ(stroma("regress list").code, 1) << "they have no reference yet";
  ASSERT_EQ(stroma("regress list --update").code, 0);
  EXPECT_EQ(stroma("regress list").code, 0);
  const fs::path file = folder_ / "references/fall/kinetic_energy.data";
  const std::string good = readText(file);
  const auto tampered = [&](const std::string& from, const std::string& to, const std::string& sentence) {
    std::string text = good;
    ASSERT_NE(text.find(from), std::string::npos) << text;
    write("references/fall/kinetic_energy.data", text.replace(text.find(from), from.size(), to));
    const Finished run = stroma("regress list");
    EXPECT_EQ(run.code, 1) << to;
    EXPECT_NE(run.out.find("kinetic_energy.data: " + sentence), std::string::npos) << run.out;
  };
  const auto line = good.rfind('\n', good.size() - 2) + 1;  // the last time and its energy
  const std::string last = good.substr(line, good.size() - line - 1), time = last.substr(0, last.find(' '));
  tampered(last, time + " nan", "number 0 is");
  tampered(last, time + " 99", "number 0 is");
  tampered(last, "7" + last.substr(last.find(' ')), "t = ");
  tampered(last, "", "5 times instead of 4");
  tampered(last, last + " 1", "1 numbers instead of 2");
  write("references/fall/kinetic_energy.data", good);
  EXPECT_EQ(stroma("regress list").code, 0);
  for (const char* word : {"data=", "data=kinetic", "data=kinetic_energy:2", "data=kinetic_energy:x"}) {
    write("list", std::string("references\nfall.xml 8 1e-9 ") + word + "\n");
    EXPECT_EQ(stroma("regress list").code, 2) << word;
  }
}

TEST_F(Regress, AnExpectationThatIsNotMetFails) {
  std::string scene = falling_scene;
  scene.insert(scene.rfind("</Node>"), R"(<Expect of="/stone/UniformMass.totalMass" is="2"/>)");
  write("fall.xml", scene);
  EXPECT_EQ(stroma("regress list").code, 0) << stroma("regress list").out;
  write("fall.xml", scene.replace(scene.find(R"(is="2")"), 6, R"(is="3")"));
  expectFailure("expected 3");
}

/// A bar of 16 cells of 1 litre, of which one goes before the fourth step: at the corner, with a point of its own, or inside.
TEST_F(Regress, NoticesACutThatIsAnother) {
  const auto bar = [&](const std::string& region) {
    write("bar.xml",
          "<Node name=\"root\" dt=\"0.0078125\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/><Node name=\"b\">"
          "<RegularGridTopology n=\"5 3 3\" min=\"0 0 0\" max=\"0.4 0.2 0.2\"/><MechanicalObject name=\"dofs\"/>"
          "<DiagonalMass massDensity=\"1000\"/><HexahedronFEMForceField method=\"svd\" youngModulus=\"50000\" poissonRatio=\"0.3\"/>"
          "<CarvingRegion begin=\"0.0234375\" end=\"0.0234375\" " + region + "/></Node></Node>");
  };
  const std::string corner = "box=\"0.33 -9 -9 9 0.1 0.1\"", two = "box=\"0.22 -9 -9 9 0.1 0.1\"";
  write("list", "references\nbar.xml 8 1e-9 data=cells:0 data=volume:1e-6\n");
  bar(corner);
  const Finished first = stroma("regress list --update");
  ASSERT_EQ(first.code, 0) << first.out << first.err;
  EXPECT_EQ(stroma("regress list").code, 0);
  EXPECT_EQ(readText(folder_ / "references/bar/cells.data"),
            "# a line for each time [s]: the time, then the numbers\n0 16\n0.015625 16\n0.03125 15\n0.046875 15\n0.0625 15\n");
  const std::string volumes = readText(folder_ / "references/bar/volume.data");
  EXPECT_NEAR(std::stod(volumes.substr(volumes.find("\n0 ") + 3)), 0.016, 1e-15);
  EXPECT_NEAR(std::stod(volumes.substr(volumes.find("\n0.0625 ") + 8)), 0.015, 1e-15);
  bar(two);
  Finished run = stroma("regress list");
  EXPECT_EQ(run.code, 1);
  EXPECT_NE(run.out.find("43 positions and 43 velocities, in the reference 44 and 44"), std::string::npos) << run.out;
  // where all points stay, and nothing moves, the cells tell
  bar(corner + " keepsPoints=\"true\"");
  ASSERT_EQ(stroma("regress list --update").code, 0);
  bar(two + " keepsPoints=\"true\"");
  run = stroma("regress list");
  EXPECT_EQ(run.code, 1);
  EXPECT_NE(run.out.find("cells.data: number 0 is 14 instead of 15"), std::string::npos) << run.out;
}

TEST_F(Regress, SeveralAtOnceSayTheSame) {
  write("other.xml", falling_scene);
  write("list", "references\nfall.xml 8 1e-9\nother.xml 4 1e-9\n");
  for (const char* wrong : {"--jobs 0", "--jobs -1", "--limit nan", "--limit -5", "--limit 0"})
    EXPECT_EQ(stroma(std::string("regress list ") + wrong).code, 2) << wrong;
  ASSERT_EQ(stroma("regress list --update --jobs 2").code, 0);
  EXPECT_EQ(stroma("regress list --jobs 2 --json json --junit junit.xml").code, 0);
  tamper([](auto& frames) { frames.back().x[0][1] += 1; });
  const Finished run = stroma("regress list --jobs 2");
  EXPECT_EQ(run.code, 1);
  EXPECT_NE(run.out.find("FAILED  fall"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("passed  other"), std::string::npos) << run.out;
  EXPECT_NE(readText(folder_ / "references/fall/origin").find("stroma regress fall --update: 8 steps"), std::string::npos);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
