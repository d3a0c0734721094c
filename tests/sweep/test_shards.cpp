// SPDX-License-Identifier: LGPL-2.1-or-later
// Shares of a sweep: together they are the whole one, whoever makes them. What starts them elsewhere is GNU parallel with
// an ssh of the test's, and a Slurm of the test's: machines that are this one. tests/sweep/slurm.py has Slurm's own daemons.
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tests/support/shell.h"
#include "tests/sweep/hanging_bar.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Six configurations.
const std::string grid = "sweep bar.xml --vary '/bar/grid.n=2 3 2,2 5 2,2 9 2' --vary /bar/fem.method=small,large -n 1 ";

/// A lock that a process has as long as this lives.
class Held {
 public:
  Held(const std::string& file, int kind) : descriptor_(open(file.c_str(), O_RDWR | O_CREAT, 0644)) {
    EXPECT_EQ(flock(descriptor_, kind | LOCK_NB), 0) << file;
  }
  Held(const Held&) = delete;
  ~Held() { close(descriptor_); }

 private:
  int descriptor_;
};

class Shards : public CommandTest {
 protected:
  using Outcomes = std::map<std::string, std::filesystem::file_time_type>;

  void SetUp() override {
    CommandTest::SetUp();
    write("bar.xml", bar);
  }
  Finished share(const std::string& which, const std::string& more = "--no-times") const {
    return stroma(grid + more + " -o parts --shard " + which);
  }
  /// The files that say that a run is whole, and when they were written.
  Outcomes outcomes() const {
    Outcomes found;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / "parts"))
      if (entry.path().string().ends_with(".outcome.json")) found[entry.path().string()] = entry.last_write_time();
    return found;
  }
  nlohmann::json table(const std::string& folder) const {
    return nlohmann::json::parse(readText(folder_ / folder / "table.json"));
  }
  /// What does not depend on who has made the runs.
  nlohmann::json results(const std::string& folder) const {
    nlohmann::json rows;
    for (const auto& row : table(folder)["configurations"])
      for (const char* name : {"key", "settings", "outcome", "error"}) rows[row["key"].get<std::string>()][name] = row[name];
    return rows;
  }
};

TEST_F(Shards, TogetherAreTheWholeSweepAndNothingIsRunTwice) {
  ASSERT_EQ(stroma(grid + "--no-times -o whole").code, 0);
  Outcomes made;
  for (const char* which : {"3/4", "1/4", "2/4", "4/4"}) {
    const Finished run = share(which);
    ASSERT_EQ(run.code, 0) << run.err;
    EXPECT_FALSE(exists("parts/table.json")) << "a share knows nothing of the others";
    const Outcomes now = outcomes();
    const std::size_t added = now.size() - made.size();
    EXPECT_TRUE(added == 1 || added == 2) << which << ": " << added << " of 6";
    EXPECT_NE(run.out.find(std::to_string(added) + " runs made"), std::string::npos) << run.out;
    for (const auto& [file, time] : made) EXPECT_EQ(now.at(file), time) << file << " was made twice";
    made = now;
  }
  EXPECT_EQ(made.size(), 6u);
  const Finished gathered = stroma(grid + "--no-times -o parts");
  ASSERT_EQ(gathered.code, 0) << gathered.err;
  EXPECT_NE(gathered.err.find("\n0 runs made"), std::string::npos) << gathered.err;
  EXPECT_EQ(outcomes(), made);
  EXPECT_EQ(results("parts"), results("whole"));
}

TEST_F(Shards, WorkBesideEachOther) {
  const std::string line = "'" STROMA_COMMAND "' " + grid + "--no-times -q -o parts --shard ";
  shell("(for i in 1 2 3 4 5 6 7; do " + line + "$i/7 >.out$i 2>&1; echo $? >.code$i & done; wait)");
  for (int i = 1; i <= 7; ++i)
    EXPECT_EQ(readText(folder_ / (".code" + std::to_string(i))), "0\n") << readText(folder_ / (".out" + std::to_string(i)));
  EXPECT_EQ(outcomes().size(), 6u) << "the seventh has nothing to do";
  const Finished gathered = stroma(grid + "--no-times -o parts");
  EXPECT_NE(gathered.err.find("\n0 runs made"), std::string::npos) << gathered.err;
}

TEST_F(Shards, WhatAKilledShareLeavesIsMadeByItOrByTheWhole) {
  ASSERT_EQ(share("1/2").code, 0);
  const Outcomes before = outcomes();
  ASSERT_EQ(before.size(), 3u);
  const std::string killed = before.begin()->first;
  std::filesystem::remove(killed);  // it is written last
  const Finished again = share("1/2");
  EXPECT_NE(again.out.find("3 of 6 configurations, 1 runs made"), std::string::npos) << again.out;
  for (const auto& [file, time] : outcomes()) EXPECT_TRUE(file == killed || time == before.at(file)) << file;
  const Finished gathered = stroma(grid + "--no-times -o parts");
  EXPECT_NE(gathered.err.find("\n3 runs made"), std::string::npos) << gathered.err;
  EXPECT_EQ(table("parts")["configurations"].size(), 6u);
}

TEST_F(Shards, KeepOthersOutOfTheFolder) {
  ASSERT_EQ(share("1/3").code, 0);
  const auto isRefused = [](const Finished& run) {
    return run.code == 2 && run.err.find("another sweep works in") != std::string::npos;
  };
  {
    const Held share_at_work(file("parts/.lock"), LOCK_SH);
    EXPECT_TRUE(isRefused(stroma(grid + "--no-times -o parts"))) << "the whole would make its runs too";
    EXPECT_FALSE(exists("parts/table.json"));
  }
  {
    const Held share_of_three(file("parts/.lock.of_3"), LOCK_SH);
    EXPECT_TRUE(isRefused(share("1/2"))) << "it has runs of each of three shares";
    EXPECT_EQ(share("2/3").code, 0);
  }
  {
    const Held same(file("parts/.lock.3_of_3"), LOCK_EX);
    EXPECT_TRUE(isRefused(share("3/3")));
  }
  {
    const Held whole(file("parts/.lock"), LOCK_EX);
    EXPECT_TRUE(isRefused(share("3/3")));
  }
  EXPECT_EQ(share("3/3").code, 0);
  EXPECT_EQ(outcomes().size(), 6u);
}

TEST_F(Shards, NumbersThatAreNoShareAreRefused) {
  for (const char* wrong : {"0/3", "4/3", "1/0", "1", "x", "1/", "/2", "1/2/3", "1/2x", "99999999999/2"}) {
    const Finished run = share(wrong);
    EXPECT_EQ(run.code, 2) << wrong;
    EXPECT_NE(run.err.find("expected I/N"), std::string::npos) << wrong << run.err;
  }
  const Finished goal = share("1/2", "--goal 'error<1%'");
  EXPECT_EQ(goal.code, 2);
  EXPECT_NE(goal.err.find("it has no shares"), std::string::npos) << goal.err;
  EXPECT_FALSE(exists("parts"));
}

TEST_F(Shards, TimesOfOtherMachinesAreNoted) {
  for (const char* which : {"1/2", "2/2"}) ASSERT_EQ(share(which, "--repeat 1").code, 0);
  const std::string gather = grid + "--repeat 1 -o parts";
  ASSERT_EQ(stroma(gather).code, 0);
  EXPECT_EQ(table("parts")["notes"].dump().find("kinds of machines"), std::string::npos);
  const std::string elsewhere = outcomes().begin()->first;
  nlohmann::json outcome = nlohmann::json::parse(readText(elsewhere));
  outcome["host"] = "node7", outcome["machine"] = "node7: Another processor, 64 cores";
  std::ofstream(elsewhere) << outcome.dump();
  ASSERT_EQ(stroma(gather).code, 0);
  const std::string notes = table("parts")["notes"].dump();
  EXPECT_NE(notes.find("2 kinds of machines"), std::string::npos) << notes;
  EXPECT_NE(notes.find("Another processor, 64 cores"), std::string::npos) << notes;
}

// ---- engines ----

/// Eight configurations; longer ones on a machine that is done before anything can happen to the work.
std::string manySteps(int times) {
  return "sweep oscillator.xml --vary dt=4e-6,2.5e-6,2e-6,1e-6 --vary /spring.stiffness=90,100 --no-times --until " +
         std::to_string(0.5 * times) + " ";
}

/// Functions of the shell. `killed COMMAND`: ends it and all that it has started when a run is whole, and notes the files that
/// say so. It waits as long as the command lives.
const std::string kill_in_the_middle = R"(
tree() { echo $1; for child in $(pgrep -P $1); do tree $child; done; }
whole() { stat -c '%n %y' "$here"/parts/runs/*/*.outcome.json; }
killed() {
  "$@" & share=$!
  while kill -0 $share 2>"$here/gone"; do
    whole >"$here/listed" 2>&1 && break
    sleep 0.01
  done
  kill -KILL $(tree $share)
  wait $share
  whole >"$here/at_the_kill"
}
)";

class Engines : public Shards {
 protected:
  void SetUp() override {
    Shards::SetUp();
    write("oscillator.xml", R"(<Node name="root" gravity="0 0 0" dt="0.01">
  <EulerImplicitSolver rayleighMass="0" rayleighStiffness="0"/><CGLinearSolver iterations="100" tolerance="1e-14"/>
  <MechanicalObject name="dofs" position="0 0 0" velocity="1 0 0"/><UniformMass totalMass="1"/>
  <RestShapeSpringsForceField name="spring" stiffness="100"/>
</Node>)");
    const std::string head = "#!/bin/sh\nhere='" + folder_.string() + "'\n" + kill_in_the_middle;
    // ssh HOST -- COMMAND
    script("ssh", head + R"(
host=$1
shift 2
echo $host >>"$here/hosts"
case $host in
  off) echo "ssh: connect to host off port 22: No route to host" >&2; exit 255 ;;
  dies) [ -e "$here/at_the_kill" ] || { killed sh -c "$*"; exit 137; } ;;
esac
cd / && exec sh -c "$*"
)");
    // the tasks of the array one after the other; the last word is the script
    script("sbatch", head + R"(
echo "$*" >>"$here/submitted"
for word; do
  case $word in --array=*) tasks=$(echo ${word#--array=} | tr , ' ') ;; esac
  script=$word
done
for task in $tasks; do
  export SLURM_ARRAY_TASK_ID=$task
  if [ -e "$here/dies" ] && [ ! -e "$here/at_the_kill" ]; then killed sh "$script"; code=137; else sh "$script" || code=$?; fi
done
exit ${code:-0}
)");
  }
  void script(const std::string& name, const std::string& text) const {
    write(name, text);
    std::filesystem::permissions(file(name), std::filesystem::perms::owner_all);
  }
  /// With the programs above, for a user whose shell runs nothing.
  static std::string commandBy(const std::string& engine, const std::string& arguments) {
    return "env -u PARALLEL SHELL=/bin/false PARALLEL_HOME=\"$PWD/.parallel\" "
           "PATH=\"$PWD:$PATH\" PARALLEL_SSH=ssh '" STROMA_COMMAND "' " + arguments + " -o parts --engine " + engine;
  }
  Finished by(const std::string& engine, const std::string& arguments) const { return shell(commandBy(engine, arguments)); }
  std::set<std::string> linesOf(const std::string& name) const {
    std::ifstream stream(folder_ / name);
    std::set<std::string> lines;
    for (std::string line; std::getline(stream, line);) lines.insert(line);
    return lines;
  }
  /// What `kill_in_the_middle` has noted is as it was, and the rest is there too.
  void expectNothingTwiceAndNothingLost(const std::string& arguments) const {
    const std::set<std::string> before = linesOf("at_the_kill");
    std::istringstream listed(shell("stat -c '%n %y' \"$PWD\"/parts/runs/*/*.outcome.json").out);
    std::set<std::string> after;
    for (std::string line; std::getline(listed, line);) after.insert(line);
    EXPECT_EQ(after.size(), 8u);
    for (const std::string& line : before) EXPECT_TRUE(after.contains(line)) << line << " was made twice";
    ASSERT_EQ(stroma(arguments + "-o whole").code, 0);
    EXPECT_EQ(results("parts"), results("whole"));
  }
};

class ParallelEngine : public Engines {
 protected:
  void SetUp() override {
    Engines::SetUp();
    // tools/setup test installs it; a tree that was built by hand may be without it, and then there is nothing to be tested
    if (!isInstalled("parallel")) GTEST_SKIP() << "GNU parallel is not installed";
  }
};

TEST_F(ParallelEngine, MakesTheSharesOnAllMachinesAndGathers) {
  const std::string engine = "parallel --sshlogin node1,node2 --shares 3";
  const Finished run = by(engine, grid + "--no-times");
  ASSERT_EQ(run.code, 0) << run.err << readText(folder_ / "parts/engine.log");
  EXPECT_NE(run.err.find("6 of 6 configurations are open: 3 shares by parallel"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("\n0 runs made, the others were there"), std::string::npos) << run.err;
  EXPECT_EQ(linesOf("hosts"), (std::set<std::string>{"node1", "node2"}));
  const Outcomes made = outcomes();
  EXPECT_EQ(made.size(), 6u);
  ASSERT_EQ(stroma(grid + "--no-times -o whole").code, 0);
  EXPECT_EQ(results("parts"), results("whole"));
  EXPECT_EQ(table("parts")["build"], table("whole")["build"]);
  EXPECT_EQ(table("parts")["seed"], table("whole")["seed"]);
  std::filesystem::remove(folder_ / "hosts");
  EXPECT_EQ(by(engine, grid + "--no-times").code, 0);
  EXPECT_FALSE(exists("hosts")) << "nothing is open, so nobody is asked";
  EXPECT_EQ(outcomes(), made);
}

TEST_F(ParallelEngine, AShareThatIsKilledInTheMiddleIsGoneOnWith) {
  for (const int times : {1, 8, 64}) {
    for (const char* old : {"parts", "whole", "at_the_kill"}) std::filesystem::remove_all(folder_ / old);
    const Finished run = by("parallel --sshlogin dies --shares 2", manySteps(times));
    ASSERT_EQ(run.code, 0) << run.err << readText(folder_ / "parts/engine.log");
    if (linesOf("at_the_kill").size() == 4) continue;  // the share was done
    ASSERT_LT(linesOf("at_the_kill").size(), 4u);
    ASSERT_GT(linesOf("at_the_kill").size(), 0u);
    expectNothingTwiceAndNothingLost(manySteps(times));
    return;
  }
  ADD_FAILURE() << "the kill came too late to show anything";
}

TEST_F(ParallelEngine, AMachineThatIsOffLeavesItsSharesToOthers) {
  const Finished lost = by("parallel --sshlogin off", grid + "--no-times");
  EXPECT_EQ(lost.code, 4) << lost.err;
  EXPECT_NE(lost.err.find("6 configurations are open after parallel"), std::string::npos) << lost.err;
  EXPECT_NE(lost.err.find("No route to host"), std::string::npos) << lost.err;
  EXPECT_FALSE(exists("parts/table.json"));
  const Finished run = by("parallel --sshlogin off,node1", grid + "--no-times");
  EXPECT_EQ(run.code, 0) << run.err << readText(folder_ / "parts/engine.log");
  EXPECT_EQ(outcomes().size(), 6u);
}

/// Shares are known by the folder where they work and by --shard.
const std::string shares_at_work = R"sh(
for process in /proc/[0-9]*; do
  [ "$(readlink $process/cwd)" = "$PWD" ] && tr '\0' ' ' <$process/cmdline | grep -e '--shard [0-9]'
done)sh";

TEST_F(ParallelEngine, ASignalEndsTheSharesToo) {
  for (const auto& [signal, code] : {std::pair("TERM", 143), std::pair("HUP", 129)}) {
    bool was_in_time = false;
    for (int times = 1; times <= 64 && !was_in_time; times *= 8) {
      std::filesystem::remove_all(folder_ / "parts");
      const Finished run = shell("{ " + commandBy("parallel --shares 2", manySteps(times)) + " & run=$!\n" +
                                 "while kill -0 $run && ! ls parts/runs/*/*.outcome.json; do sleep 0.01; done >listed 2>&1\n"
                                 "kill -" + signal + " $run; wait $run; }");
      if (run.code == 0) continue;  // all was done
      was_in_time = true;
      EXPECT_EQ(run.code, code) << run.err << readText(folder_ / "parts/engine.log");
      EXPECT_EQ(shell(shares_at_work).out, "");
    }
    EXPECT_TRUE(was_in_time) << signal << " came too late to show anything";
  }
}

TEST_F(Engines, SlurmMakesOnlyTheSharesThatAreOpen) {
  for (const int times : {1, 8, 64}) {
    for (const char* old : {"parts", "whole", "at_the_kill", "submitted"}) std::filesystem::remove_all(folder_ / old);
    write("dies", "");
    const Finished run = by("slurm --shares 2 --engine-options=\"--partition=long --mem=2G\"", manySteps(times));
    ASSERT_EQ(run.code, 0) << run.err << readText(folder_ / "parts/engine.log");
    if (linesOf("at_the_kill").size() == 4) continue;  // the share was done
    ASSERT_GT(linesOf("at_the_kill").size(), 0u);
    const std::string submitted = readText(folder_ / "submitted");
    EXPECT_NE(submitted.find("--array=1,2 --partition=long --mem=2G "), std::string::npos) << submitted;
    EXPECT_NE(submitted.find("--array=1 --partition=long --mem=2G "), std::string::npos) << submitted;
    expectNothingTwiceAndNothingLost(manySteps(times));
    return;
  }
  ADD_FAILURE() << "the kill came too late to show anything";
}

/// A parallel of the test's: it warns, as GNU's does of much, and its share finds no scene.
TEST_F(Engines, AWarningOfWhatStartsAShareDoesNotHideWhyItFailed) {
  script("parallel", "#!/bin/sh\nhere='" + folder_.string() + R"('
echo 'parallel: Warning: only so many processes are allowed' >&2
rm "$here/bar.xml"
for word; do script=$word; done
sh "$script" 1
)");
  const Finished run = by("parallel --shares 2", grid + "--no-times");
  EXPECT_EQ(run.code, 4) << run.err;
  EXPECT_NE(readText(folder_ / "parts/engine.log").find("parallel: Warning"), std::string::npos);
  const std::size_t reason = run.err.find("configurations are open after parallel");
  ASSERT_NE(reason, std::string::npos) << run.err;
  EXPECT_NE(run.err.find("bar.xml: there is no such file", reason), std::string::npos) << run.err;
  EXPECT_EQ(run.err.find("parallel: Warning"), std::string::npos) << run.err;
}

TEST_F(Engines, WhatTheyCannotDoIsRefused) {
  const auto isRefused = [this](const std::string& arguments, const std::string& sentence) {
    const Finished run = stroma(grid + "--no-times -o parts " + arguments);
    EXPECT_EQ(run.code, 2) << arguments;
    EXPECT_NE(run.err.find(sentence), std::string::npos) << arguments << ": " << run.err;
    EXPECT_FALSE(exists("parts")) << arguments;
  };
  isRefused("--engine condor", "--engine condor: expected parallel or slurm");
  isRefused("--sshlogin node1", "--sshlogin is for --engine, which is missing");
  isRefused("--shares 3", "--shares is for --engine, which is missing");
  isRefused("--engine slurm --sshlogin node1", "Slurm knows its machines");
  isRefused("--engine slurm --shares 0", "--shares 0: expected 1 or more");
  isRefused("--engine slurm --shard 1/2", "--engine makes shares itself");
  const Finished none = shell("env PATH=/ '" STROMA_COMMAND "' " + grid + "--no-times -o parts --engine slurm");
  EXPECT_EQ(none.code, 2);
  EXPECT_NE(none.err.find("there is no program sbatch on the path"), std::string::npos) << none.err;
  EXPECT_FALSE(exists("parts"));
  const Finished goal = by("slurm", grid + "--goal 'error<1%'");
  EXPECT_EQ(goal.code, 2);
  EXPECT_NE(goal.err.find("leave --engine out"), std::string::npos) << goal.err;
  EXPECT_FALSE(exists("submitted"));
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
