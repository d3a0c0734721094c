// SPDX-License-Identifier: LGPL-2.1-or-later
// `stroma sweep` beside kills, signals and other sweeps: what is run, and how often.
#include "tests/sweep/sweep_fixture.h"

namespace stroma::test {
namespace {

/// Eight runs of many steps, `times` as many as usual.
std::string manySteps(int times = 1) {
  return "sweep oscillator.xml --vary dt=4e-6,2.5e-6,2e-6,1e-6 --vary /spring.stiffness=90,100 --until " +
         std::to_string(0.1 * times) + " ";
}
/// A loop of the shell that ends when `condition` holds, the process is over, or after ten minutes: only a hang takes so long.
std::string waitFor(const std::string& condition, const std::string& process) {
  return "for try in $(seq 60000); do " + condition + " && break; [ -e /proc/" + process + "/exe ] || break; sleep 0.01; done\n";
}
constexpr int longest[] = {1, 5, 40, 320};  ///< on a machine that is done before anything can happen to the work

TEST_F(Sweep, ASecondSweepAtOnceIsRefusedAndRemovesNothing) {
  write("oscillator.xml", oscillator);
  for (const int times : longest) {
    std::filesystem::remove_all(folder_ / "out");
    const std::string line = "'" STROMA_COMMAND "' sweep oscillator.xml --vary dt=4e-6,2e-6 --repeat 1 -o out --until " +
                             std::to_string(0.1 * times);
    // the first one stands still, with its runs before it, while the second one tries
    shell("exec 3>.codes\n" + line + " 2>.first & first=$!\n" + waitFor("ls out/runs/* >.found 2>&1", "$first") +
          "kill -STOP $first\n" + line +
          " 2>.second; echo second $? >&3; kill -CONT $first; wait $first; echo first $? >&3");
    if (readText(folder_ / ".codes") != "second 0\nfirst 0\n") break;  // else the first one was over
  }
  EXPECT_EQ(readText(folder_ / ".codes"), "second 2\nfirst 0\n") << readText(folder_ / ".second");
  EXPECT_TRUE(has(readText(folder_ / ".second"), "another sweep works in")) << readText(folder_ / ".second");
  EXPECT_EQ(outcomes("out").size(), 2u);
}

/// All of them begin at once in a folder that is not there: however the others are refused, one sweep is whole.
TEST_F(Sweep, OfSweepsThatBeginTogetherOneIsWhole) {
  write("oscillator.xml", oscillator);
  shell("for i in 1 2 3 4; do '" STROMA_COMMAND
        "' sweep oscillator.xml --vary dt=4e-5,2e-5 --until 0.5 --repeat 1 -o out "
        ">.out$i 2>&1 & done; wait");
  EXPECT_EQ(outcomes("out").size(), 2u);
  EXPECT_EQ(table("out")["configurations"].size(), 2u);
}

TEST_F(Sweep, AKilledSweepGoesOnAndRunsNothingTwice) {
  write("oscillator.xml", oscillator);
  std::map<std::string, std::filesystem::file_time_type> before;
  std::string arguments;
  for (const int times : longest) {
    std::filesystem::remove_all(folder_ / "out");
    arguments = manySteps(times) + "-o out --repeat 2";
    shell("'" STROMA_COMMAND "' " + arguments + " & sweep=$!\n" + waitFor("ls out/runs/*/*.outcome.json >.found 2>&1", "$sweep") +
          "kill -KILL $sweep; wait $sweep");
    before = outcomes("out");
    if (before.size() < 16) break;
  }
  ASSERT_GT(before.size(), 0u) << "the kill came too early to show anything";
  ASSERT_LT(before.size(), 16u) << "the kill came too late to show anything";
  const Finished again = stroma(arguments);
  ASSERT_EQ(again.code, 0) << again.err;
  const auto after = outcomes("out");
  EXPECT_EQ(after.size(), 16u);
  for (const auto& [file, time] : before) EXPECT_EQ(after.at(file), time) << file << " was made twice";
  EXPECT_TRUE(has(again.err, std::to_string(16 - before.size()) + " runs made")) << again.err;
  const Finished third = stroma(arguments);
  EXPECT_TRUE(has(third.err, "\n0 runs made")) << third.err;
  EXPECT_EQ(outcomes("out"), after);
}

TEST_F(Sweep, AKilledWorkerIsRunAgain) {
  write("oscillator.xml", oscillator);
  Finished run;
  for (const int times : longest) {
    std::filesystem::remove_all(folder_ / "out");
    run = shell("'" STROMA_COMMAND "' " + manySteps(times) + "-o out --repeat 1 & sweep=$!\n" +
                waitFor("[ -d out/runs ] && pkill -KILL -P $sweep", "$sweep") + "wait $sweep");
    if (has(run.err, "killed by signal 9")) break;
  }
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_TRUE(has(run.err, "killed by signal 9")) << run.err;
  const auto json = table("out");
  EXPECT_EQ(json["configurations"].size(), 8u);
  for (const auto& row : json["configurations"]) EXPECT_EQ(row["outcome"], "done");
}

/// The signal waits when the sweep begins, so that it comes neither early nor late: at the first run, as between two.
TEST_F(Sweep, ASignalBetweenRunsStopsIt) {
  write("oscillator.xml", oscillator);
  write("pending.py",
        "import os, signal, sys\nsignal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])\n"
        "os.kill(os.getpid(), signal.SIGINT)\nos.execv(sys.argv[1], sys.argv[1:])\n");
  const Finished run = shell("exec python3 pending.py '" STROMA_COMMAND "' " + manySteps() + "-o out");
  EXPECT_EQ(run.code, 130) << run.err;
  EXPECT_TRUE(has(run.err, "stopped before the first run")) << run.err;
  EXPECT_FALSE(exists("out"));
}

TEST_F(Sweep, ARunThatIsAlwaysKilledIsARowWithItsSentence) {
  write("oscillator.xml", oscillator);
  const Finished run =
      shell("ulimit -t 2; '" STROMA_COMMAND "' sweep oscillator.xml --vary dt=1e-2,2e-8 --until 1 -o out --repeat 1");
  EXPECT_EQ(run.code, 0) << run.err;
  const auto rows = table("out")["configurations"];
  EXPECT_EQ(rows[0]["outcome"], "done");
  EXPECT_EQ(rows[1]["outcome"], "killed");
  EXPECT_TRUE(has(rows[1]["sentence"], "3 times")) << rows[1]["sentence"];
  EXPECT_FALSE(rows[1]["on_front"].get<bool>());
  EXPECT_TRUE(has(run.out, "the finest value of dt has no result")) << run.out;
}

TEST_F(Sweep, AChangedSceneIsRunAgain) {
  write("bar.xml", bar);
  const std::string line = std::string("sweep bar.xml") + bar_meshes + "-o out";
  ASSERT_EQ(stroma(line).code, 0);
  const auto before = outcomes("out");
  std::string changed = bar;
  changed.replace(changed.find("1e6"), 3, "2e6");
  write("bar.xml", changed);
  ASSERT_EQ(stroma(line).code, 0);
  EXPECT_EQ(outcomes("out").size(), 2 * before.size());
}

TEST_F(Sweep, TimesAreThoseOfTimedRunsOnly) {
  write("bar.xml", bar);
  const std::string line = "sweep bar.xml --vary '/bar/grid.n=2 3 2,2 5 2' -n 1 -q -o out ";
  ASSERT_EQ(stroma(line + "--no-times").code, 0);
  auto rows = table("out")["configurations"];
  for (const auto& row : rows) {
    EXPECT_TRUE(row["seconds"].is_null() && row["ms_per_step"].is_null()) << row;
    EXPECT_FALSE(row["on_front"].get<bool>());
    EXPECT_FALSE(row["timed"].get<bool>());
  }
  ASSERT_EQ(stroma(line + "--repeat 2").code, 0);
  rows = table("out")["configurations"];
  for (const auto& row : rows) {
    EXPECT_GT(row["seconds"].get<double>(), 0);
    EXPECT_EQ(row["measured"].size(), 3u) << "one that tells no time, and two that do";
  }
}

TEST_F(Sweep, AnEndThatCannotBeReadIsARowAndTheRestIsCompared) {
  write("bar.xml", bar);
  const std::string line = std::string("sweep bar.xml") + bar_meshes + "-o out";
  ASSERT_EQ(stroma(line).code, 0);
  const std::string finest = table("out")["configurations"][3]["key"];
  write("out/runs/" + finest + "/end.values", "damaged");
  const Finished again = stroma(line);
  EXPECT_EQ(again.code, 0) << again.err;
  const auto rows = table("out")["configurations"];
  EXPECT_EQ(rows[3]["outcome"], "not comparable");
  EXPECT_TRUE(rows[3]["seconds"].is_null());
  EXPECT_TRUE(rows[2]["is_reference"].get<bool>());
  EXPECT_FALSE(rows[0]["error"].is_null());
}

TEST_F(Sweep, NamesOfFilesAreThoseOfTheUsersFolder) {
  const std::string hanging = R"(<Node name="root" dt="0.01" gravity="0 -10 0">
  <EulerExplicitSolver/>
  <MeshOBJLoader name="loader" filename="none.obj"/>
  <MechanicalObject name="dofs" position="@loader.position"/>
  <UniformMass totalMass="2"/>
</Node>)";
  write("stone.xml", hanging);
  write("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
      write("sub/two.obj", "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n");
  const Finished run = stroma(
      "sweep stone.xml --vary /loader.filename=one.obj,sub/two.obj -n 2 --no-times -o out --error /dofs.displacement");
  EXPECT_EQ(run.code, 0) << run.err;
  for (const auto& row : table("out")["configurations"]) EXPECT_EQ(row["outcome"], "done") << row;
}

TEST_F(Sweep, CommandsAreQuotedForAShell) {
  write("it's.xml", bar);
  ASSERT_EQ(stroma("sweep \"it's.xml\" --vary '/bar/grid.n=2 3 2,2 5 2' -n 1 --no-times -q -o out").code, 0);
  const auto json = table("out");
  EXPECT_TRUE(has(json["command"], R"(stroma sweep 'it'\''s.xml' --vary '/bar/grid.n=2 3 2,2 5 2' -n 1)"))
      << json["command"];
}

TEST_F(Sweep, ItWaitsForItsRunsWhereEndsOfProcessesAreIgnored) {
  write("bar.xml", bar);
  write("ignoring.sh", "trap '' CHLD\nexec '" STROMA_COMMAND
                       "' sweep bar.xml --vary '/bar/grid.n=2 3 2,2 5 2' -n 1 --no-times -q -o out\n");
  const Finished run = shell("timeout -s KILL 600 sh ignoring.sh");  // it would wait for ever
  EXPECT_EQ(run.code, 0) << run.err;
}

}  // namespace
}  // namespace stroma::test
