// SPDX-License-Identifier: LGPL-2.1-or-later
// `stroma stress` as a user meets it: faults of force fields outside the tree, crashes, repetition, going on.
#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/support/scene_text.h"
#include "tests/support/shell.h"
#include "tools/stress/outcome.h"

namespace stroma::test {
namespace {

using nlohmann::json;

std::string cube(const std::string& type) {
  return R"(<Node name="root" dt="0.01" gravity="0 0 0">
  <EulerImplicitSolver rayleighMass="5" rayleighStiffness="0.01"/>
  <SparseLDLSolver/>
  <MeshTopology name="mesh" position="0 0 0 0.1 0 0 0 0.1 0 0.1 0.1 0 0 0 0.1 0.1 0 0.1 0 0.1 0.1 0.1 0.1 0.1"
    tetrahedra="0 1 3 7 0 3 2 7 0 2 6 7 0 6 4 7 0 4 5 7 0 5 1 7"/>
  <MechanicalObject name="dofs"/>
  <UniformMass totalMass="1"/>
  <FixedProjectiveConstraint name="held" indices="0 1 2 3"/>
  <)" + type +
         R"( name="fem" stiffness="5000"/>
</Node>)";
}

class Stress : public CommandTest {
 protected:
  /// However long those before it take: else none begins after two minutes.
  static constexpr const char* all_cases = " --seconds 1000000";
  static constexpr const char* module = " --module " STROMA_TEST_MODULES "/faulty.so ";
  json stress(const std::string& type, const std::string& arguments, int code) {
    write("cube.xml", cube(type));
    const Finished run = stroma("stress cube.xml -q --json" + std::string(all_cases) + module + arguments);
    EXPECT_EQ(run.code, code) << run.err << run.out;
    return json::parse(run.out, nullptr, false);
  }
  /// The sentences of cases that end so.
  static std::string sentences(const json& result, const std::string& ending) {
    std::string all;
    for (const json& one : result["cases"])
      if (one["ending"] == ending)
        for (const json& sentence : one.value("sentences", json::array())) all += sentence.get<std::string>() + "\n";
    return all;
  }
};

TEST_F(Stress, ARightForceFieldOutsideTheTreeBreaksNowhere) {
  const json result = stress("RightTetrahedra", "--cases 40", 0);
  EXPECT_EQ(result["endings"]["breaks"], 0) << sentences(result, "breaks");
  EXPECT_GT(result["endings"]["good"].get<int>(), 5);
  EXPECT_GT(result["endings"]["stops"].get<int>(), 5);
}

TEST_F(Stress, AQuarterOfAMegabyteIsTooLittle) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer takes more address space than a limit leaves";
#endif
  const json result = stress("RightTetrahedra", "--cases 40", 0);
  bool is_there = false;
  for (const json& one : result["cases"]) {
    if (!one["text"].get<std::string>().starts_with("0.25 MB more")) continue;
    is_there = true;
    EXPECT_EQ(one["ending"], "stops") << one;
  }
  EXPECT_TRUE(is_there);
}

TEST_F(Stress, AWrongSignOfADerivativeIsFound) {
  const json result = stress("WrongSignTetrahedra", "--cases 4", 1);
  EXPECT_NE(sentences(result, "breaks")
                .find("/fem (WrongSignTetrahedra): its stiffness is not the derivative of its force: the error is"),
            std::string::npos)
      << sentences(result, "breaks");
  EXPECT_NE(sentences(result, "breaks").find("of the other sign"), std::string::npos);
}

TEST_F(Stress, AFactorOfTwoInAForceIsFound) {
  const json result = stress("DoubledTetrahedra", "--cases 4", 1);
  EXPECT_NE(sentences(result, "breaks").find("/fem (DoubledTetrahedra): the force is not the slope of its energy"),
            std::string::npos)
      << sentences(result, "breaks");
}

TEST_F(Stress, ADroppedCheckOfInversionIsFound) {
  const std::string found = sentences(stress("BlindTetrahedra", "--cases 4", 1), "breaks");
  EXPECT_NE(found.find("/fem (BlindTetrahedra): "), std::string::npos) << found;
  EXPECT_NE(found.find("cells are inside out, and its J is positive in all: it does not see inversion"),
            std::string::npos)
      << found;
}

TEST_F(Stress, AWrongSignOfTheAssembledMatrixAloneIsFound) {
  const std::string found = sentences(stress("WrongMatrixTetrahedra", "--cases 4", 1), "breaks");
  EXPECT_NE(found.find("/fem (WrongMatrixTetrahedra): its matrix does not match its product: error 2"),
            std::string::npos)
      << found;
}

TEST_F(Stress, ADerivativeThatIsNoNumberIsFound) {
  const std::string found = sentences(stress("HollowTetrahedra", "--cases 4", 1), "breaks");
  EXPECT_NE(found.find("/fem (HollowTetrahedra): its stiffness is no number where its force is one"),
            std::string::npos)
      << found;
}

TEST_F(Stress, AWrongSignOfADampingIsFound) {
  const std::string found = sentences(stress("ViscousTetrahedra", "--cases 4", 1), "breaks");
  EXPECT_NE(found.find("/fem (ViscousTetrahedra): its damping is not the derivative of its force"), std::string::npos)
      << found;
}

TEST_F(Stress, ACellIsInsideOutWhereTheCaseSaysSo) {
  const json result = stress("CrashingTetrahedra", "--cases 4", 1);
  for (const json& one : result["cases"])
    if (one["text"] == "forces, energies and derivatives with a cell inside out") {
      EXPECT_EQ(one["ending"], "breaks") << one;
      return;
    }
  FAIL() << result;
}

TEST_F(Stress, AStopThatNamesNobodyBreaks) {
  const std::string found = sentences(stress("NamelessTetrahedra", "--cases 14", 1), "breaks");
  EXPECT_NE(found.find("it stops with a sentence that names no component: more than 3 N/m cannot be borne"),
            std::string::npos)
      << found;
}

TEST_F(Stress, WhatIsHeldMovesInShortRunsToo) {
  const json result = stress("RightTetrahedra", "--cases 24 -n 1", 0);
  int moves = 0;
  for (const json& one : result["cases"])
    if (one["group"] == "sudden moves" && one["ending"] != "stops") {
      EXPECT_GE(one["steps"], 3) << one;
      ++moves;
    }
  EXPECT_GT(moves, 0);
}

TEST_F(Stress, OneCaseAloneIsWrittenWhereItIsAskedFor) {
  write("cube.xml", cube("RightTetrahedra"));
  const Finished run = stroma("stress cube.xml" + std::string(module) + "--set fem.stiffness=4000 --case 25 --json=one.json");
  EXPECT_EQ(run.code, 0) << run.err;
  const json one = json::parse(readText(folder_ / "one.json"), nullptr, false);
  EXPECT_EQ(one["case"], 25);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "results"));
  // what does it by hand is the same scene
  const auto at = run.out.find("by hand: stroma ");
  ASSERT_NE(at, std::string::npos) << run.out;
  EXPECT_NE(run.out.find("--set /fem.stiffness=4000", at), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("--module ", at), std::string::npos) << run.out;
}

TEST_F(Stress, ACrashIsSeenAndTheOthersGoOn) {
  const json result = stress("CrashingTetrahedra", "--cases 14", 1);
  EXPECT_EQ(result["cases"].size(), 14u);
  EXPECT_NE(sentences(result, "breaks").find("it crashes with SIGSEGV"), std::string::npos)
      << sentences(result, "breaks");
  EXPECT_GT(result["endings"]["good"].get<int>(), 1);
}

TEST_F(Stress, ASeedRepeatsItselfAndOneCaseAlone) {
  const json one = stress("RightTetrahedra", "--cases 30 --seed 5 -o a --jobs 3", 0);
  const json other = stress("RightTetrahedra", "--cases 30 --seed 5 -o b --jobs 1", 0);
  ASSERT_EQ(one["cases"].size(), 30u);
  EXPECT_EQ(one["cases"], other["cases"]);
  for (const int number : {5, 9, 20}) {
    const json alone = stress("RightTetrahedra", "--seed 5 --case " + std::to_string(number), 0);
    EXPECT_EQ(alone["text"], one["cases"][number - 1]["text"]);
    EXPECT_EQ(alone["ending"], one["cases"][number - 1]["ending"]);
    EXPECT_EQ(alone.value("distance", 0.), one["cases"][number - 1].value("distance", 0.));
  }
  const json elsewhere = stress("RightTetrahedra", "--cases 30 --seed 6 -o c", 0);
  EXPECT_NE(one["cases"], elsewhere["cases"]);
}

TEST_F(Stress, GoesOnWhereItWasStopped) {
  stress("RightTetrahedra", "--cases 6 -o out", 0);
  const std::string before = readText(folder_ / "out/cases.jsonl");
  // a case that was made is not made again: what it says is kept as it is
  std::string marked = before;
  const auto at = marked.find("\"steps\":0");
  ASSERT_NE(at, std::string::npos) << before;
  marked.replace(at, 9, "\"steps\":77");
  write("out/cases.jsonl", marked + "{\"case\":7,\"end");  // killed while it wrote
  const json result = stress("RightTetrahedra", "--cases 12 -o out", 0);
  EXPECT_EQ(result["cases"].size(), 12u);
  EXPECT_TRUE(
      std::any_of(result["cases"].begin(), result["cases"].end(), [](const json& one) { return one["steps"] == 77; }));
  // another scene is another campaign
  const json other = stress("BlindTetrahedra", "--cases 3 -o out", 0);
  EXPECT_EQ(other["cases"].size(), 3u);
  EXPECT_FALSE(
      std::any_of(other["cases"].begin(), other["cases"].end(), [](const json& one) { return one["steps"] == 77; }));
  EXPECT_NE(readText(folder_ / "out/stress.html").find("What cube.xml bears"), std::string::npos);
}

TEST_F(Stress, ASceneWithoutAResultIsSaidToHaveNone) {
  write("burst.xml", R"(<Node name="root" dt="1" gravity="0 0 -9.81">
  <EulerExplicitSolver/><MechanicalObject name="dofs" position="0 0 0  0 0 0.01"/><UniformMass totalMass="1e-9"/>
  <SpringForceField name="spring" springsIndices1="0" springsIndices2="1" lengths="0.02" stiffness="1e30"/></Node>)");
  const Finished run = stroma("stress burst.xml -q --cases 3");
  EXPECT_EQ(run.code, 3) << run.out << run.err;
  EXPECT_NE(run.err.find("the scene has no result as it is"), std::string::npos) << run.err;
}

// ---- scenes of other fields ----

class StressOfScene : public Stress, public testing::WithParamInterface<const char*> {};

/// A few cases of each kind; the whole list takes two minutes.
TEST_P(StressOfScene, BreaksNowhere) {
  const std::string scene = std::string(STROMA_SOURCE_DIR "/tests/stress/scenes/") + GetParam() + ".xml";
  const Finished run = stroma("stress " + scene + " -q --json --cases 30 -n 4 -o out" + all_cases);
  EXPECT_EQ(run.code, 0) << run.err;
  const json result = json::parse(run.out, nullptr, false);
  EXPECT_EQ(sentences(result, "breaks"), "");
  EXPECT_EQ(result["cases"].size(), 30u);
}

INSTANTIATE_TEST_SUITE_P(Fields, StressOfScene, testing::Values("finger", "tendon", "leaflet", "cartilage", "breast"));
/// Frames in cells, and contacts of both kinds.
INSTANTIATE_TEST_SUITE_P(Components, StressOfScene, testing::Values("sensor", "pressed", "folding"));

/// A slab that is cut after 50 ms: a step of 10 s is beyond that, and no other observer of the scene is asked.
TEST_F(Stress, WhatEndsARunByItselfDoesSoHereToo) {
  const Finished run = stroma("stress " STROMA_SOURCE_DIR "/tests/stress/scenes/incision.xml -q --json --cases 48 -n 4 -o out" +
                              std::string(all_cases));
  EXPECT_EQ(run.code, 0) << run.err;
  const json result = json::parse(run.out, nullptr, false);
  EXPECT_EQ(sentences(result, "breaks"), "");
  bool was_cut = false;
  for (const json& one : result["cases"]) {
    if (!one["text"].get<std::string>().starts_with("/.dt x 1e+3")) continue;
    was_cut = true;
    EXPECT_EQ(one["ending"], "stops") << one;
    EXPECT_NE(one["sentences"].dump().find("/slab/knife: changes a mesh at t = 0.05 s"), std::string::npos) << one;
  }
  EXPECT_TRUE(was_cut);
}

// ---- what is perturbed ----

TEST(StressTargets, AreFoundByUnitAndRange) {
  Simulation simulation(sceneFromText(R"(<Node name="root" dt="0.02" gravity="0 0 -9.81">
    <EulerImplicitSolver rayleighStiffness="0.1"/><CGLinearSolver tolerance="1e-9"/>
    <RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject/><UniformMass totalMass="3"/>
    <HexahedronFEMForceField name="fem" youngModulus="1e4" poissonRatio="0.3"/></Node>)"));
  std::map<std::string, stress::Target> found;
  for (const stress::Target& target : stress::targetsOf(simulation)) found[target.name()] = target;
  EXPECT_EQ(found.at("/.dt").quantity, stress::Quantity::time);
  EXPECT_EQ(found.at("/fem.youngModulus").quantity, stress::Quantity::stiffness);
  EXPECT_EQ(found.at("/fem.poissonRatio").quantity, stress::Quantity::ratio);
  EXPECT_EQ(found.at("/fem.youngModulus").scaled(2), "1000000");
  EXPECT_EQ(found.at("/fem.youngModulus").scaled(0), "");
  const stress::Target& ratio = found.at("/fem.poissonRatio");
  EXPECT_NEAR(std::stod(ratio.nearEnd(4, true)), ratio.high - 1e-4 * (ratio.high - ratio.low), 1e-12);
  EXPECT_GT(std::stod(ratio.scaled(3)), 0.3);
  EXPECT_LT(std::stod(ratio.scaled(3)), 0.5);
  const stress::CaseList cases(simulation, 1), again(simulation, 1);
  for (long number = 1; number < cases.size() + 300; ++number) {
    const stress::Case one = cases.at(number);
    EXPECT_EQ(one.number, number);
    EXPECT_FALSE(one.text.empty());
    EXPECT_EQ(one.text, again.at(number).text);
    if (one.kind != stress::Kind::attribute) continue;
    // another value, all of it: gravity has three numbers
    ASSERT_TRUE(one.override);
    EXPECT_NE(one.override->value, "") << one.text;
    const auto& target = found.at(one.override->path + "." + one.override->attribute);
    EXPECT_EQ(std::size_t(std::count(one.override->value.begin(), one.override->value.end(), ' ')) + 1,
              target.values.size())
        << one.text;
    EXPECT_EQ(one.text.substr(one.text.size() - one.override->value.size()), one.override->value);
  }
}

TEST(StressTargets, AreThoseThatWereWrittenAndNotWhatFollowsFromThem) {
  Simulation simulation(sceneFromText(R"(<Node name="root" dt="0.02" gravity="0 0 0">
    <EulerImplicitSolver/><CGLinearSolver/>
    <RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject/><UniformMass totalMass="3"/>
    <ConstantForceField name="all" totalForce="0 0 8"/><ConstantForceField name="each" force="0 0 1"/></Node>)"));
  std::set<std::string> found;
  for (const stress::Target& target : stress::targetsOf(simulation)) found.insert(target.name());
  EXPECT_TRUE(found.contains("/all.totalForce") && found.contains("/each.force"));
  EXPECT_FALSE(found.contains("/all.forces") || found.contains("/each.forces")) << "both at once are refused";
}

TEST(StressTargets, NothingIsMovedThatCannotMove) {
  Simulation simulation(sceneFromText(R"(<Node name="root" dt="0.02" gravity="0 0 -9.81">
    <EulerImplicitSolver/><CGLinearSolver/>
    <RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject/><UniformMass totalMass="3"/>
    <FixedProjectiveConstraint fixAll="true"/>
    <HexahedronFEMForceField name="fem" youngModulus="1e4" poissonRatio="0.3"/></Node>)"));
  const stress::CaseList cases(simulation, 1);
  int moves = 0;
  for (long number = 1; number <= cases.size(); ++number) {
    const stress::Case one = cases.at(number);
    EXPECT_NE(one.kind, stress::Kind::shape) << one.text;
    EXPECT_FALSE(one.kind == stress::Kind::forces && one.shape != stress::Shape::small) << one.text;
    EXPECT_FALSE(one.kind == stress::Kind::not_finite &&
                 (one.entry == stress::Entry::position || one.entry == stress::Entry::velocity))
        << one.text;
    moves += one.kind == stress::Kind::move;
  }
  EXPECT_EQ(moves, 2);
}

TEST(StressOutcome, IsTheSameAfterItWasWritten) {
  stress::Outcome outcome;
  outcome.ending = stress::Ending::doubt, outcome.steps = 3, outcome.sentences = {"a \"doubt\"", "two\nlines"};
  for (const double distance : {-1., 0., 0.25, std::numeric_limits<double>::infinity()}) {
    outcome.distance = distance;
    const stress::Outcome back = stress::outcomeFrom(nlohmann::ordered_json::parse(stress::toJson(outcome).dump()));
    EXPECT_EQ(back.ending, outcome.ending);
    EXPECT_EQ(back.steps, 3);
    EXPECT_EQ(back.sentences, outcome.sentences);
    EXPECT_EQ(back.distance, std::min(distance, std::numeric_limits<double>::max()));
  }
}

}  // namespace
}  // namespace stroma::test
