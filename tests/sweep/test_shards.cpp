// SPDX-License-Identifier: LGPL-2.1-or-later
// Shares of a sweep: together they are the whole one, whoever makes them.
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <map>
#include <nlohmann/json.hpp>

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

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
