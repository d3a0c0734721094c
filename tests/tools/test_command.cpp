// SPDX-License-Identifier: LGPL-2.1-or-later
// The command as a user meets it: exit codes, sentences, recordings, JSON.
#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "framework/simulation/state_file.h"
#include "tests/support/shell.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using Command = CommandTest;

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// ---- usage ----

TEST_F(Command, EverySubcommandHasHelpWithExamples) {
  for (const char* name : {"run", "watch", "check", "explain", "list", "doc", "regress"}) {
    const Finished run = stroma(std::string(name) + " --help");
    EXPECT_EQ(run.code, 0) << name;
    EXPECT_TRUE(has(run.out, "usage: stroma " + std::string(name))) << run.out;
    EXPECT_TRUE(has(run.out, "examples:")) << run.out;
    EXPECT_EQ(run.err, "");
  }
  EXPECT_EQ(stroma("--help").code, 0);
  EXPECT_EQ(stroma("").code, 2);
}

TEST_F(Command, MisspeltWordsAreAnsweredWithTheNearest) {
  write("fall.xml", falling_scene);
  const std::pair<const char*, const char*> cases[] = {
      {"rnu fall.xml", "did you mean 'run'?"},
      {"run fall.xml --recrod out", "did you mean --record?"},
      {"run fall.xml --jsn", "did you mean --json?"},
      {"check fall.xml --thread 2", "did you mean --threads?"},
      {"doc MechanicalObjct", "did you mean MechanicalObject?"},
      {"run", "SCENE is missing"},
      {"run fall.xml -n 1 --until 2", "exclude each other"},
      {"run fall.xml -n -3", "expected 0 or more"},
      {"run fall.xml --until nan", "--until"},
      {"run fall.xml --record-every 2", "needs --record"},
      {"run fall.xml --threads 0", "expected 1 to 1024"},
      {"run fall.xml extra.xml", "too many arguments"},
      {"run absent.xml", "absent.xml"},
      {"run fall.xml --set nonsense", "nonsense"},
      {"run fall.xml --set /stone/dof.position=1", "dofs"},
  };
  for (const auto& [arguments, expected] : cases) {
    const Finished run = stroma(arguments);
    EXPECT_EQ(run.code, 2) << arguments << "\n" << run.err;
    EXPECT_TRUE(has(run.err, expected)) << arguments << "\n" << run.err;
    EXPECT_EQ(run.out, "") << arguments;
  }
}

// ---- run ----

TEST_F(Command, WarningsAfterLoadingAreInTheSummaryToo) {
  write("block.xml", R"(<Node name="root" gravity="0 -10 0"><CondensedStaticSolver cacheFolder="auto"/>
    <RegularGridTopology n="3 3 3" min="0 0 0" max="0.1 0.1 0.1"/><MechanicalObject/><UniformMass totalMass="1"/>
    <HexahedronFEMForceField method="small" youngModulus="1e4" poissonRatio="0.3"/>
    <FixedProjectiveConstraint indices="0 1 2 3 4 5 6 7 8"/></Node>)");
  const Finished run = shell("env -u HOME -u XDG_CACHE_HOME '" STROMA_COMMAND "' run block.xml -n 1 --quiet --no-record --json -");
  EXPECT_EQ(run.code, 0) << run.err;
  const auto at = run.err.find("finds no folder");
  EXPECT_NE(at, std::string::npos) << run.err;
  EXPECT_EQ(run.err.find("finds no folder", at + 1), std::string::npos) << "twice: " << run.err;
  EXPECT_TRUE(has(nlohmann::json::parse(run.out)["warnings"].dump(), "finds no folder")) << run.out;
}

/// A spring of 100 N/m that a hand pulls with 300 N/m from the fourth step on.
constexpr const char* sprung =
    "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><StaticSolver/><SparseLDLSolver/>"
    "<MechanicalObject name=\"dofs\" position=\"0 0 0\"/><UniformMass totalMass=\"1\"/>"
    "<RestShapeSpringsForceField name=\"spring\" stiffness=\"100\"/></Node>";
constexpr const char* actions =
    "{\"stroma\":\"actions\",\"version\":1,\"scene\":\"sprung.xml\"}\n"
    "{\"step\":3,\"input\":1,\"state\":\"/dofs\",\"nodes\":[0],\"targets\":[[1,0,0]],\"stiffness\":300}\n"
    "{\"step\":5,\"set\":\"/spring\",\"attribute\":\"stiffness\",\"value\":\"900\"}\n"
    "{\"step\":8,\"end\":1}\n";

TEST_F(Command, WhatWasDoneToARunIsReplayed) {
  write("sprung.xml", sprung);
  write("hand.actions", actions);
  std::vector<std::string> hashes;
  const std::tuple<int, const char*, double> runs[] = {{3, "replayed 0 actions; the run ended before 3 more", 0},
                                                       {4, "replayed 1 action; the run ended before 2 more", 0.75},
                                                       {6, "replayed 2 actions; the run ended before 1 more", 0.25},
                                                       {9, "replayed 3 actions\n", 0}};
  for (const auto& [steps, told, x] : runs) {
    const Finished run = stroma("run sprung.xml --replay hand.actions --record out -n " + std::to_string(steps));
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_TRUE(has(run.out, told)) << run.out;
    EXPECT_FALSE(has(run.err, "recorded with")) << run.err;
    EXPECT_NEAR(readStateFile(file("out/dofs.state.gz")).back().x[0].x(), x, 1e-12);
  }
  const Finished on = stroma("run sprung.xml --replay hand.actions --record out -n 6 --json --quiet");
  EXPECT_EQ(nlohmann::json::parse(on.out)["replayed"], nlohmann::json({{"actions", 2}, {"later", 1}}));
  const Finished resumed = stroma("run sprung.xml --replay hand.actions --record out -n 9 --resume");
  EXPECT_TRUE(has(resumed.out, "replayed 1 action; 2 before the checkpoint\n")) << resumed.out;
  write("other.xml", sprung);
  EXPECT_TRUE(has(stroma("run other.xml --replay hand.actions -n 9").err,
                  "note: hand.actions was recorded with the scene sprung.xml\n"));
}

TEST_F(Command, AReplayThatCannotBeIsRefusedBeforeOrEndsTheRun) {
  write("sprung.xml", sprung);
  const auto with = [&](const std::string& before, const std::string& after) {
    std::string text = actions;
    const std::size_t at = text.find(before);
    write("hand.actions", text.replace(at, before.size(), after));
    return stroma("run sprung.xml --replay hand.actions -n 9");
  };
  const std::tuple<const char*, const char*, const char*> unfit[] = {
      {"stroma", "srtoma", "hand.actions:1: error: "},
      {"\"step\":5", "\"step\":2", "hand.actions:3: error: step 2 comes after step 3"},
      {"/spring", "/sprin", "did you mean '/spring'?"},
      {"[0]", "[1]", "hand.actions:2: error: action 1 of the replay, before step 4: an input names node 1"}};
  for (const auto& [before, after, told] : unfit) {
    const Finished run = with(before, after);
    EXPECT_EQ(run.code, 2) << run.err;
    EXPECT_TRUE(has(run.err, told)) << run.err;
    EXPECT_TRUE(has(run.err, "nothing was run")) << run.err;
  }
  EXPECT_EQ(stroma("run sprung.xml --replay absent.actions").code, 2);
  EXPECT_EQ(stroma("run sprung.xml --replay hand.actions --json=hand.actions").code, 2);
  EXPECT_FALSE(exists("results/sprung/last"));
  const Finished run = with("900", "-900");
  EXPECT_EQ(run.code, 3) << "steps were made: an exit code of 2 would say that nothing was run";
  EXPECT_TRUE(has(run.err, "not replayed: hand.actions:3: error: action 2 of the replay, before step 6: ")) << run.err;
  EXPECT_TRUE(has(run.err, "the last good state (t = 0.05) is in results/sprung/last/run.instants")) << run.err;
  EXPECT_TRUE(has(run.out, "sprung.xml: not replayed after 5 steps")) << run.out;
}

TEST_F(Command, AConstraintThatDoesNotHoldEndsTheRun) {
  write("behind.xml",
        "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><EulerExplicitSolver/>"
        "<MechanicalObject position=\"0 0 -0.5  0 1 0\"/><UniformMass totalMass=\"2\"/>"
        "<FixedProjectiveConstraint indices=\"0\"/><PlaneConstraint normal=\"0 0 1\" d=\"0\"/></Node>");
  const Finished run = stroma("run behind.xml -n 5 --quiet --json report.json");
  EXPECT_EQ(run.code, 3) << run.err;
  EXPECT_TRUE(has(run.err, "not converged: ")) << run.err;
  EXPECT_TRUE(has(run.err, "fixed there")) << run.err;
  const auto report = nlohmann::json::parse(readText(folder_ / "report.json"));
  EXPECT_EQ(report["outcome"], "not converged");
  EXPECT_TRUE(has(report["reason"].get<std::string>(), "node 0 is 0.5 behind plane 0"));
}

/// Of the precomputations that tell of it: tests/condensation.
TEST_F(Command, LongWorkTellsHowFarItIsAndQuietRunsTellNothing) {
  const std::string with_module = " -n 0 --no-record --module '" STROMA_TEST_MODULES "/fickle.so'";
  const auto run = [&](const char* operations, const std::string& options) {
    write("slow.xml", fmt::format("<Node name=\"root\" gravity=\"0 0 0\"><EulerImplicitSolver/><SluggishSolver name=\"slow\" "
                                  "operations=\"{}\"/><MechanicalObject position=\"0 0 0\"/><UniformMass totalMass=\"1\"/></Node>",
                                  operations));
    const Finished finished = stroma("run slow.xml" + with_module + options);
    EXPECT_EQ(finished.code, 0) << finished.err;
    return finished;
  };
  const std::string told = run("1.01e11", "").err;
  int lines = 0, estimates = 0;
  for (std::size_t at = 0; (at = told.find(" %", at)) != std::string::npos; ++at) ++lines;
  for (std::size_t at = 0; (at = told.find(" to go\n", at)) != std::string::npos; ++at) ++estimates;
  EXPECT_EQ(lines, 5) << told;      // each quarter
  EXPECT_EQ(estimates, 3) << told;  // but for the first and the last
  EXPECT_TRUE(has(told, "/slow: sluggish work: 0 %\n") && has(told, "/slow: sluggish work: 100 %\n")) << told;
  EXPECT_FALSE(has(run("0.99e11", "").err, "sluggish work")) << "work of a moment";
  const Finished quiet = run("1.01e11", " --quiet");
  EXPECT_EQ(quiet.out + quiet.err, "");
}

TEST_F(Command, RunRecordsFirstEveryKthAndLast) {
  write("fall.xml", falling_scene);
  const Finished run = stroma("run fall.xml -n 7 --record out --record-every 3 --quiet");
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.out + run.err, "");
  const auto frames = readStateFile((folder_ / "out/stone.dofs.state.gz").string());
  ASSERT_EQ(frames.size(), 4u);
  const double times[] = {0, 0.03, 0.06, 0.07};
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(frames[i].time, times[i], 1e-15);
  EXPECT_EQ(frames[0].x[1], Vec3(1, 0, 0));
  EXPECT_EQ(frames[0].v[1], Vec3(0, 2, 0));
  // the velocity under a constant acceleration is exact for every scheme of order one
  EXPECT_NEAR(frames[3].v[0].y(), -10 * 0.07, 1e-12);
  EXPECT_NEAR(frames[3].v[1].y(), 2 - 10 * 0.07, 1e-12);
  EXPECT_FALSE(exists("out/stone.dofs.state.gz.part"));
}

/// A run goes on from its checkpoint, with what components remember: the halves of a run end where the whole does, and
/// leave the files of the whole.
TEST_F(Command, RunGoesOnFromACheckpoint) {
  write("whole.xml",
        "<Node name=\"root\" dt=\"0.015625\" gravity=\"0 0 -9.81\"><RegularGridTopology name=\"grid\" n=\"2 2 3\" "
        "min=\"0 0 0\" max=\"0.04 0.04 0.1\"/><EulerImplicitSolver/><SparseLDLSolver/><Node name=\"b\">"
        "<TetrahedronSetTopologyContainer name=\"tets\"/><Hexa2TetraTopologicalMapping input=\"@../grid\" "
        "output=\"@tets\"/><MechanicalObject name=\"dofs\"/><UniformMass totalMass=\"0.1\"/>"
        "<TetrahedronHyperelasticityFEMForceField materialName=\"NeoHookean\" youngModulus=\"5000\" "
        "poissonRatio=\"0.4\" viscous=\"true\" ParameterAlpha=\"0.5\" ParameterTau=\"0.3\"/>"
        "<TetrahedronPorousForceField fluidFraction=\"0.5\" bulkModulus=\"400\" limitModulus=\"2200\" "
        "permeability=\"1e-7\"/><FixedProjectiveConstraint indices=\"0 1 2 3\"/>"
        "<EnergyMonitor filename=\"energy.txt\"/><Monitor name=\"tip\" indices=\"11\" ExportPositions=\"true\"/>"
        "<WriteState filename=\"all.state\" period=\"0.03\"/></Node></Node>");
  const std::vector<std::string> files = {"energy.txt", "tip_x.txt", "all.state"};
  const auto contents = [&] {
    std::string text;
    for (const std::string& file : files) text += readText(folder_ / file);
    return text;
  };
  ASSERT_EQ(stroma("run whole.xml -n 32 --record whole --quiet").code, 0);
  const std::string whole = contents();
  ASSERT_EQ(stroma("run whole.xml -n 16 --record half --quiet").code, 0);
  ASSERT_TRUE(exists("half/last.checkpoint"));
  const Finished on = stroma("run whole.xml -n 32 --record half --restart half/last.checkpoint --quiet");
  ASSERT_EQ(on.code, 0) << on.err;
  EXPECT_EQ(contents(), whole);
  const auto frames = [&](const std::string& folder) {
    return readStateFile((folder_ / folder / "b.dofs.state.gz").string());
  };
  ASSERT_EQ(frames("half").size(), frames("whole").size());
  for (std::size_t i = 0; i < frames("half").size(); ++i) {
    EXPECT_EQ(frames("half")[i].time, frames("whole")[i].time);
    EXPECT_TRUE(frames("half")[i].x == frames("whole")[i].x && frames("half")[i].v == frames("whole")[i].v) << i;
  }
  EXPECT_EQ(readText(folder_ / "half/last.checkpoint"), readText(folder_ / "whole/last.checkpoint"));
}

TEST_F(Command, RunRefusesWhatIsNoCheckpointOfTheScene) {
  write("fall.xml", falling_scene);
  ASSERT_EQ(stroma("run fall.xml -n 2 --record out --checkpoint-every 1 --quiet").code, 0);
  const std::string whole = readText(folder_ / "out/last.checkpoint");
  const auto refusal = [&](const std::string& contents) {
    write("bad.checkpoint", contents);
    const Finished run = stroma("run fall.xml -n 4 --restart bad.checkpoint --quiet");
    EXPECT_EQ(run.code, 2) << run.err;
    return run.err;
  };
  EXPECT_TRUE(has(refusal("T= 0\n"), "this is no checkpoint"));
  EXPECT_TRUE(has(refusal(whole.substr(0, whole.size() - 1)), "cut short"));
  EXPECT_TRUE(has(refusal(whole.substr(0, 60)), "cut short"));
  std::string flipped = whole;
  flipped[whole.size() - 3] ^= 1;
  EXPECT_TRUE(has(refusal(flipped), "damaged"));
  flipped = whole;
  flipped[whole.find("value") + 8] ^= 1;
  EXPECT_TRUE(has(refusal(flipped), "damaged"));
  std::string other = falling_scene;
  other.replace(other.find("dofs"), 4, "stone");
  write("other.xml", other);
  const Finished run = stroma("run other.xml -n 4 --restart out/last.checkpoint --quiet");
  EXPECT_EQ(run.code, 2);
  EXPECT_TRUE(has(run.err, "another scene")) << run.err;
}

TEST_F(Command, JsonIsAllThereIsOnStandardOutput) {
  write("fall.xml", falling_scene);
  const auto began = std::chrono::steady_clock::now();
  const Finished run = stroma("run fall.xml --until 0.05 --json");
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  ASSERT_EQ(run.code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json.at("outcome"), "done");
  EXPECT_EQ(json.at("steps"), 5);
  EXPECT_NEAR(json.at("simulated_time").get<double>(), 0.05, 1e-15);
  for (const char* key : {"wall_seconds", "load_seconds", "peak_memory_bytes"}) EXPECT_GT(json.at(key), 0) << key;
  for (const char* key : {"mean", "median", "p99"}) EXPECT_GE(json.at("ms_per_step").at(key), 0) << key;
  for (const char* key : {"force", "product", "assembly", "solve", "observers", "other"})
    EXPECT_GE(json.at("phase_seconds").at(key), 0) << key;
  EXPECT_EQ(json.at("threads"), 1);
  EXPECT_EQ(json.at("state_hash").get<std::string>().size(), 16u);
  EXPECT_FALSE(json.at("modules_opened").empty());
  // 1/2 m v^2 with 1 kg each: 0 and 2 m/s at the start
  EXPECT_NEAR(json.at("energies").at("start").at("kinetic").get<double>(), 2, 1e-14);
  if (took.count() < 1) {  // else it was no moment: the machine has much else to do
    EXPECT_EQ(run.err, "") << "a run of a moment needs no progress";
  }

  EXPECT_EQ(stroma("run fall.xml -n 5 --json=summary.json").code, 0);
  EXPECT_EQ(nlohmann::json::parse(readText(folder_ / "summary.json")).at("state_hash"), json.at("state_hash"));
}

TEST_F(Command, OverridesAndThreadsDoWhatTheySay) {
  write("fall.xml", falling_scene);
  const auto hash = [&](const std::string& options) {
    return nlohmann::json::parse(stroma("run fall.xml -n 3 --json " + options).out).at("state_hash").get<std::string>();
  };
  EXPECT_EQ(hash(""), hash("--threads 2"));
  EXPECT_NE(hash(""), hash("--set /.gravity='0 -5 0'"));
}

TEST_F(Command, ADivergedRunKeepsTheLastGoodState) {
  write("burst.xml", R"(<Node name="root" dt="0.01" gravity="0 -10 0">
  <EulerExplicitSolver/>
  <MechanicalObject name="dofs" position="0 0 0" velocity="1e308 0 0"/>
  <UniformMass totalMass="2"/>
  <ConstantForceField name="push" indices="0" forces="1.7e308 0 0"/>
</Node>
)");
  const Finished run = stroma("run burst.xml --set /.dt=1 -n 50 --quiet");
  EXPECT_EQ(run.code, 3) << run.err;
  EXPECT_TRUE(has(run.err, "diverged: step 1 ")) << run.err;
  EXPECT_TRUE(has(run.err, "node 0 of /dofs")) << run.err;
  EXPECT_TRUE(has(run.err, "is in results/burst/last/run.instants, results/burst/last/last.checkpoint\n")) << run.err;
  const auto instants = instantsIn(folder_ / "results/burst/last/run.instants");
  EXPECT_EQ(instants, std::vector<double>({0, 0, 0, 0, 1e308, 0, 0})) << "time, position, velocity";
  const Finished none = stroma("run burst.xml --set /.dt=1 -n 50 --quiet --no-record");
  EXPECT_EQ(none.code, 3);
  EXPECT_TRUE(has(none.err, "is in no file (--no-record)\n")) << none.err;

  const Finished json = stroma("run burst.xml --set /.dt=1 --record out --json --quiet");
  EXPECT_EQ(json.code, 3);
  EXPECT_EQ(nlohmann::json::parse(json.out).at("outcome"), "diverged");
  EXPECT_TRUE(exists("out/dofs.state.gz"));
}

/// A cube of springs that is mirrored where it starts rests so: the run says it, and only a strict one fails.
TEST_F(Command, AStrictRunDoesNotEndInDoubt) {
  write("mirrored.xml", R"(<Node name="root" dt="0.01" gravity="0 0 0">
  <EulerImplicitSolver/><CGLinearSolver/>
  <MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/>
  <MechanicalObject name="dofs" rest_position="0 0 0  1 0 0  0 1 0  0 0 1" position="0 0 0  1 0 0  0 1 0  0 0 -1"/>
  <UniformMass totalMass="1"/><MeshSpringForceField stiffness="100"/>
</Node>
)");
  const std::string sentence = "1 of 1 tetrahedra are inverted";
  const Finished mild = stroma("run mirrored.xml -n 3 --quiet");
  EXPECT_EQ(mild.code, 0) << mild.err;
  EXPECT_TRUE(has(mild.err, sentence)) << mild.err;
  const Finished strict = stroma("run mirrored.xml -n 3 --strict --json --quiet");
  EXPECT_EQ(strict.code, 3) << strict.err;
  EXPECT_TRUE(has(strict.err, sentence)) << strict.err;
  EXPECT_EQ(nlohmann::json::parse(strict.out).at("outcome"), "in doubt");
  const Finished fine = stroma("run mirrored.xml -n 3 --strict --quiet --set /dofs.position='0 0 0 1 0 0 0 1 0 0 0 1'");
  EXPECT_EQ(fine.code, 0) << fine.err;
}

// ---- check, explain, list, doc ----

TEST_F(Command, BadInputWritesNothing) {
  write("bad.xml", R"(<Node name="root">
  <EulerExplicitSolver/>
  <MechanicalObject name="dofs" positon="0 0 0"/>
  <UniformMas totalMass="2"/>
</Node>
)");
  const Finished run = stroma("run bad.xml --record out");
  EXPECT_EQ(run.code, 2);
  EXPECT_FALSE(exists("out"));
  EXPECT_EQ(stroma("run bad.xml").code, 2);
  EXPECT_FALSE(exists("results/bad/last"));
  EXPECT_TRUE(has(run.err, "bad.xml:3")) << run.err;
  EXPECT_TRUE(has(run.err, "position")) << run.err;
  EXPECT_TRUE(has(run.err, "bad.xml:4")) << run.err;
  EXPECT_TRUE(has(run.err, "UniformMass")) << run.err;

  const Finished check = stroma("check bad.xml --json");
  EXPECT_EQ(check.code, 2);
  const auto json = nlohmann::json::parse(check.out);
  EXPECT_EQ(json.at("ok"), false);
  EXPECT_GE(json.at("problems").size(), 2u);
  EXPECT_EQ(json.at("problems")[0].at("severity"), "error");
}

TEST_F(Command, CheckAndExplainAGoodScene) {
  write("fall.xml", falling_scene);
  const Finished check = stroma("check fall.xml");
  EXPECT_EQ(check.code, 0) << check.err;
  EXPECT_TRUE(has(check.out, "ok: 2 nodes in 1 state, 0 force fields, 1 mass")) << check.out;
  EXPECT_EQ(nlohmann::json::parse(stroma("check fall.xml --json").out).at("ok"), true);

  const Finished explain = stroma("explain fall.xml");
  EXPECT_EQ(explain.code, 0) << explain.err;
  EXPECT_TRUE(has(explain.out, "/stone/dofs")) << explain.out;
  EXPECT_TRUE(has(explain.out, "modules opened: ")) << explain.out;
  EXPECT_TRUE(has(explain.out, "modules not opened")) << explain.out;
  EXPECT_TRUE(has(explain.out, "observers: none")) << explain.out;
}

TEST_F(Command, ARunTellsThatItsMeshIsTooCoarse) {
  write("beam.xml", R"(<Node name="root" dt="1" gravity="0 -9.81 0"><StaticSolver/><SparseLDLSolver/>
  <RegularGridTopology name="grid" n="9 3 3" min="0 0 0" max="0.2 0.05 0.05"/><MechanicalObject/><UniformMass totalMass="0.1"/>
  <HexahedronFEMForceField name="fem" youngModulus="60000" poissonRatio="0.3" method="svd"/>
  <BoxROI name="end" box="-0.001 -1 -1  0.001 1 1"/><FixedProjectiveConstraint indices="@end.indices"/></Node>)");
  const std::string sentence = "note: /fem at t = 1 s: by the jumps of the strain between cells";
  const Finished bent = stroma("run beam.xml -n 1 --no-record --json out.json");
  EXPECT_EQ(bent.code, 0) << bent.err;
  EXPECT_TRUE(has(bent.err, sentence)) << bent.err;
  EXPECT_EQ(nlohmann::json::parse(readText(folder_ / "out.json")).at("coarse_meshes").size(), 1u);
  EXPECT_EQ(stroma("run beam.xml -n 1 --no-record --strict").code, 0) << "an estimate is no doubt";
  EXPECT_FALSE(has(stroma("run beam.xml -n 1 --no-record --quiet").err, sentence));
  EXPECT_FALSE(has(stroma("run beam.xml -n 1 --no-record --set gravity=\"0 0 0\"").err, sentence)) << "at rest";
}

/// A ball comes to touch the floor in step 40, of contact that nothing answers: a run that ends there says what the next
/// step would have been refused for.
TEST_F(Command, ARunThatEndsInAContactWithoutAnAnswerSaysSo) {
  write("ball.xml", R"(<Node name="root" dt="0.01" gravity="0 -9.81 0"><CollisionPipeline/>
  <NewProximityIntersection alarmDistance="0.2" contactDistance="0.1"/><EulerExplicitSolver/>
  <Node name="ball"><MechanicalObject position="0 1 0"/><UniformMass totalMass="1"/><SphereCollisionModel radius="0.1"/></Node>
  <Node name="floor"><MeshTopology position="-9 0 -9  9 0 -9  9 0 9  -9 0 9" triangles="0 1 2  0 2 3"/><MechanicalObject/>
  <UniformMass totalMass="1"/><FixedProjectiveConstraint fixAll="true"/><TriangleCollisionModel simulated="false" moving="false"/>
  </Node></Node>)");
  const std::string sentence = "/CollisionPipeline at t = 0.4: another step would be rejected. ";
  const Finished before = stroma("run ball.xml -n 39 --no-record"), at = stroma("run ball.xml -n 40 --no-record");
  EXPECT_FALSE(has(before.err, "rejected")) << before.err;
  EXPECT_TRUE(has(at.err, sentence) && has(at.err, "nearer than their contact distance of 0.1:")) << at.err;
  EXPECT_EQ(at.code, 0);
  EXPECT_EQ(stroma("run ball.xml -n 40 --no-record --strict --quiet").code, 3);
  EXPECT_EQ(stroma("run ball.xml -n 41 --no-record --quiet").code, 3) << "refused";
}

/// Cloth that bends in its plane: eight triangles over the width are not enough.
TEST_F(Command, ARunTellsThatAMembraneIsTooCoarse) {
  constexpr int across = 8, along = 64;
  std::string positions, triangles, held;
  for (int j = 0; j <= across; ++j)
    for (int i = 0; i <= along; ++i) positions += fmt::format("{} {} 0 ", 0.8 * i / along, 0.1 * j / across);
  for (int j = 0; j < across; ++j)
    for (int i = 0; i < along; ++i) {
      const int a = i + (along + 1) * j, b = a + along + 1;
      triangles += fmt::format("{} {} {} {} {} {} ", a, a + 1, b + 1, a, b + 1, b);
    }
  for (int j = 0; j <= across; ++j) held += fmt::format("{} ", (along + 1) * j);
  write("strip.xml", fmt::format(R"(<Node name="root" dt="1" gravity="0 -0.05 0"><StaticSolver/><SparseLDLSolver/>
  <MeshTopology position="{}" triangles="{}"/><MechanicalObject/><MeshMatrixMass massDensity="4"/>
  <TriangularFEMForceField name="fem" youngModulus="1e5" poissonRatio="0.3" thickness="0.004"/>
  <PartialFixedProjectiveConstraint indices="0-{}" fixedDirections="0 0 1"/>
  <FixedProjectiveConstraint indices="{}"/></Node>)",
                                 positions, triangles, (along + 1) * (across + 1) - 1, held));
  const Finished run = stroma("run strip.xml -n 1 --no-record");
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_TRUE(has(run.err, "note: /fem at t = 1 s: by the jumps of the strain")) << run.err;
}

/// Milliseconds are not told as seconds, nor grams as kilograms.
TEST_F(Command, NumbersAreToldInTheUnitsOfTheScene) {
  const auto beam = [](const std::string& more) {
    return R"(<Node name="root" units="mm g ms" dt="5" gravity="0 -9.81e-3 0"><StaticSolver/><SparseLDLSolver/>
  <RegularGridTopology name="grid" n="9 3 3" min="0 0 0" max="200 50 50"/><MechanicalObject name="dofs"/>
  <UniformMass totalMass="500"/>
  <HexahedronFEMForceField name="fem" youngModulus="0.06" poissonRatio="0.3" method="svd"/>
  <BoxROI name="end" box="-1 -1 -1  1 60 60"/><FixedProjectiveConstraint indices="@end.indices"/>)" +
           more + "</Node>";
  };
  write("beam.xml", beam(R"(<Expect of="/dofs.displacement" axis="y" is="1"/>)"));
  const Finished plan = stroma("explain beam.xml"), run = stroma("run beam.xml -n 1 --no-record");
  EXPECT_TRUE(has(plan.out, "time step 5 ms from t = 0 ms\n")) << plan.out;
  EXPECT_TRUE(has(plan.out, "500 g, diagonal")) << plan.out;
  const auto json = nlohmann::json::parse(stroma("explain beam.xml --json").out);
  EXPECT_EQ(json.at("units"), "mm, g, ms");
  EXPECT_FALSE(has(json.dump(), "\"kg\""));
  EXPECT_TRUE(has(run.err, "/fem at t = 5 ms: by the jumps of the strain")) << run.err;
  EXPECT_TRUE(has(run.err, "at t = 5 ms, expected 1")) << run.err;
  write("far.xml", beam("<Node name='copy'><MechanicalObject name='dofs' position='0 0 99'/><SubsetMapping radius='0.1'/></Node>"));
  const Finished refused = stroma("run far.xml -n 1");
  EXPECT_EQ(refused.code, 2);
  EXPECT_TRUE(has(refused.err, "is 49 mm from the nearest node of /dofs (expected at most radius = 0.1 mm")) << refused.err;
}

TEST_F(Command, ListAndDoc) {
  const Finished list = stroma("list WriteSt");
  EXPECT_EQ(list.code, 0) << list.err;
  EXPECT_EQ(list.out.rfind("WriteState", 0), 0u) << list.out;
  EXPECT_TRUE(has(list.out, "output"));
  EXPECT_GT(stroma("list").out.size(), list.out.size());
  EXPECT_EQ(stroma("list NoSuchThing").code, 2);

  const Finished doc = stroma("doc WriteState");
  EXPECT_EQ(doc.code, 0) << doc.err;
  EXPECT_TRUE(has(doc.out, "period (")) << doc.out;
  EXPECT_TRUE(has(doc.out, "[s]")) << doc.out;
  EXPECT_TRUE(has(doc.out, "Example:")) << doc.out;
}

TEST_F(Command, AStrictRunTakesSolvesThatStoppedShortForADoubt) {
  write("chain.xml", capped_chain);
  const Finished run = stroma("run chain.xml -n 3"), strict = stroma("run chain.xml -n 3 --strict");
  EXPECT_EQ(run.code, 0);
  EXPECT_EQ(strict.code, 3);
  for (const Finished& finished : {run, strict})
    EXPECT_TRUE(has(finished.err, "stopped before its tolerance in 2 of 3 steps (worst relative residual"))
        << finished.err;
  EXPECT_EQ(stroma("run chain.xml -n 3 --strict --set /CGLinearSolver.iterations=100").code, 0);
}

TEST_F(Command, ARunWithoutAResultIsNoneWhenItIsResumed) {
  // one iteration does not find the equilibrium of a hardening chain
  write("chain.xml",
        "<Node name=\"root\" dt=\"1\" gravity=\"0 -10 0\"><StaticSolver newton_iterations=\"1\"/><SparseLDLSolver/>"
        "<MechanicalObject position=\"0 0 0  1 0 0  2 0 0\"/><UniformMass totalMass=\"1\"/>"
        "<SpringForceField springsIndices1=\"0 1\" springsIndices2=\"1 2\" stiffness=\"30\" lengths=\"1 1\"/>"
        "<FixedProjectiveConstraint indices=\"0\"/></Node>");
  const Finished first = stroma("run chain.xml -n 2 --record out");
  EXPECT_EQ(first.code, 3) << first.err;
  const Finished resumed = stroma("run chain.xml -n 2 --record out --resume");
  EXPECT_EQ(resumed.code, 3) << resumed.err;
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
