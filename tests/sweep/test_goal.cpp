// SPDX-License-Identifier: LGPL-2.1-or-later
// The search for the cheapest configuration against the whole grid.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/folder_fixture.h"
#include "tools/sweep/assessment.h"
#include "tools/sweep/chart.h"
#include "tools/sweep/cores.h"
#include "tools/sweep/digest.h"
#include "tools/sweep/goal.h"
#include "tools/sweep/probe.h"
#include "tools/sweep/run_folder.h"

namespace stroma::sweep {
namespace {

Axis ordered(AxisKind kind, std::vector<double> sizes) {
  Axis axis;
  axis.attributes = {"/a.b"};
  for (const double size : sizes) axis.values.push_back({std::to_string(size)});
  axis.kind = kind, axis.sizes = std::move(sizes);
  return axis;
}

Axis words(std::size_t count) {
  Axis axis;
  axis.attributes = {"/a.word"};
  for (std::size_t k = 0; k < count; ++k) axis.values.push_back({std::string(1, char('a' + k))});
  return axis;
}

struct Grid {
  std::vector<Axis> axes{ordered(AxisKind::mesh, {0.4, 0.2, 0.1, 0.05, 0.025}),
                         ordered(AxisKind::time_step, {0.08, 0.04, 0.02, 0.01}), words(3)};
  std::vector<double> error_of_word, price_of_word;
  double errorOf(const std::vector<std::size_t>& c) const {
    return error_of_word[c[2]] * (std::pow(axes[0].sizes[c[0]], 2) + axes[1].sizes[c[1]]);
  }
  double secondsOf(const std::vector<std::size_t>& c) const {
    return price_of_word[c[2]] / (std::pow(axes[0].sizes[c[0]], 3) * axes[1].sizes[c[1]]);
  }
};

TEST(GoalSearch, FindsWhatTheWholeGridFinds) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(0.2, 5);
  for (int round = 0; round < 50; ++round) {
    Grid grid;
    for (int k = 0; k < 3; ++k)
      grid.error_of_word.push_back(share(random)), grid.price_of_word.push_back(share(random));
    const double bound = 0.01 * std::pow(share(random), 2);
    std::vector<std::size_t> wanted;
    double least = INFINITY;
    for (std::size_t i = 0; i < 60; ++i) {
      const std::vector<std::size_t> c{i / 12, i / 3 % 4, i % 3};
      if (grid.errorOf(c) < bound && grid.secondsOf(c) < least) wanted = c, least = grid.secondsOf(c);
    }
    GoalSearch search(grid.axes, bound);
    int runs = 0;
    for (auto next = search.next(); !next.empty(); next = search.next(), ++runs)
      search.learn(next, {true, grid.errorOf(next), grid.secondsOf(next)});
    EXPECT_EQ(search.cheapest(), wanted) << round;
    EXPECT_LE(runs, 30) << "half of the grid is more than it takes";
  }
}

TEST(GoalSearch, RunsWithoutAResultSpeakForNobody) {
  const std::vector<Axis> axes{ordered(AxisKind::tolerance, {1e-2, 1e-4, 1e-6})};
  GoalSearch search(axes, 0.1);
  for (auto next = search.next(); !next.empty(); next = search.next())
    search.learn(next, {next[0] != 1, next[0] == 0 ? 0.5 : 0.01, double(next[0])});
  EXPECT_EQ(search.cheapest(), std::vector<std::size_t>{2});
}

TEST(GoalSearch, BoundsAreSharesOrPercent) {
  EXPECT_DOUBLE_EQ(parseGoal("error<1%"), 0.01);
  EXPECT_DOUBLE_EQ(parseGoal("error < 0.25"), 0.25);
  for (const char* wrong : {"error>1%", "1%", "error<", "error<0", "error<x", "time<1"})
    EXPECT_THROW(parseGoal(wrong), std::invalid_argument) << wrong;
}

Entry entryOf(double seconds, double error, bool good = true) {
  Entry entry;
  entry.configuration.choice = {0};
  entry.runs.outcome = good ? "done" : "diverged";
  Repetition run;
  run.seconds = seconds;
  entry.runs.repetitions.push_back(run);
  if (good) entry.error = error;
  return entry;
}

TEST(Repetition, IsDisturbedByOthersOnItsCores) {
  Repetition run;
  run.process_seconds = 10, run.cpu_seconds = 9.5, run.cores = {3};
  EXPECT_FALSE(run.wasDisturbed());
  run.cpu_seconds = 8.5;
  EXPECT_TRUE(run.wasDisturbed());
  // of four threads, one half and three quarters of the time wait for each other: nobody else is there
  run.cores = {0, 1, 2, 3}, run.cpu_seconds = 25, run.others_seconds = 3.9;
  EXPECT_FALSE(run.wasDisturbed());
  run.others_seconds = 4.1;
  EXPECT_TRUE(run.wasDisturbed());
  run.timed = false;
  EXPECT_FALSE(run.wasDisturbed());
}

TEST(Repetition, CoresAreBusyAsTheSystemSays) {
  const std::string text = "cpu  9 9 9 9 9 9 9 9 9 9\ncpu0 100 20 30 4000 500 6 7 8 0 0\ncpu1 1 0 0 99 0 0 0 0 0 0\n"
                           "cpu10 50 0 0 0 0 0 0 0 0 0\nintr 5\n";
  EXPECT_DOUBLE_EQ(busySecondsIn(text, {0}, 100), 1.71);
  EXPECT_DOUBLE_EQ(busySecondsIn(text, {1, 10}, 100), 0.51);
  EXPECT_DOUBLE_EQ(busySecondsIn(text, {2}, 100), 0);
  EXPECT_GT(busySeconds(physicalCores()), 0);
}

TEST(Probed, FilesAreThoseOfTheValuesThatReadThem) {
  Probed probed;
  probed.inputs = {"scene", "a", "b", "x", "both"};
  probed.of_value = {{{"scene", "a", "both"}, {"scene", "b", "both"}, {}}, {{"scene", "a", "both"}, {"scene", "a", "both", "x", "b"}}};
  using Files = Probed::Files;
  EXPECT_EQ(probed.inputsWith({0, 0}), (Files{"scene", "a", "both"}));
  EXPECT_EQ(probed.inputsWith({1, 0}), (Files{"scene", "b", "both"}));
  EXPECT_EQ(probed.inputsWith({0, 1}), (Files{"scene", "a", "b", "both", "x"})) << "the second value reads b by itself";
  EXPECT_EQ(probed.inputsWith({2, 0}), probed.inputs) << "nobody knows what a value reads that the first ones refuse";
  EXPECT_EQ(probed.inputsWith({}), probed.inputs) << "of --reference-set, where it does not say its own";
}

TEST(Front, HasWhatNothingBeatsAndNoFailure) {
  std::vector<Entry> entries{entryOf(1, 0.5),  entryOf(2, 0.2),   entryOf(3, 0.3),
                             entryOf(4, 0.01), entryOf(5, 0.009), entryOf(0.1, 0, false)};
  markFront(entries, 0.02);
  std::vector<bool> front;
  for (const Entry& entry : entries) front.push_back(entry.on_front);
  EXPECT_EQ(front, (std::vector<bool>{true, true, false, true, false, false}))
      << "below the uncertainty of 0.02 more time buys nothing that can be seen";
}

TEST(Front, RunsWithoutTimesAreNotOnIt) {
  std::vector<Entry> entries{entryOf(0, 0.5), entryOf(2, 0.2)};
  entries[0].runs.repetitions[0].timed = false;
  EXPECT_EQ(entries[0].runs.medianOf(&Repetition::seconds), 0);
  markFront(entries, 0.02);
  EXPECT_FALSE(entries[0].on_front);
  EXPECT_TRUE(entries[1].on_front);
}

TEST(Chart, LabelsAreNotCutWithinACharacter) {
  for (std::size_t before = 15; before < 30; ++before) {
    Chart chart;
    chart.id = "chart";
    ChartLine line;
    line.label = std::string(before, 'a') + "\u00b5\u00b5\u00b5\u00b5\u00b5\u00b5\u00b5\u00b5";
    line.points = {{1, 1, 0, false, false}, {2, 2, 0, false, false}};
    chart.lines.push_back(line);
    const std::string text = svgOf(chart, true, false);
    const std::size_t cut = text.find("\u2026");
    ASSERT_NE(cut, std::string::npos);
    EXPECT_NE(static_cast<unsigned char>(text[cut - 1]), 0xc2) << "the first byte of two";
  }
}

class Digest : public test::FolderTest {};

TEST_F(Digest, ChangesWithTheModulesOfTheUser) {
  const std::string module = write("module.so", "one"), before = digestOfBuild("/bin/sh", {module});
  EXPECT_EQ(digestOfBuild("/bin/sh", {module}), before);
  write("module.so", "two");
  EXPECT_NE(digestOfBuild("/bin/sh", {module}), before);
}

TEST(Axes, ZipVariesTogetherAndCommasCanBeKept) {
  const auto axes = parseAxes({"dt=0.1,0.2", "/a.file=x\\,y.msh,z.msh"}, {"/a.n=1,2,3; /b.m=4,5,6"});
  ASSERT_EQ(axes.size(), 3u);
  EXPECT_EQ(axes[1].values[0][0], "x,y.msh");
  EXPECT_EQ(axes[2].size(), 3u);
  EXPECT_EQ(axes[2].settingText(1), "a.n=2, b.m=5");
  for (const char* wrong : {"dt", "dt=", "/a=1", "dt=1,,2", "dt=1,1"})
    EXPECT_THROW(parseAxes({wrong}, {}), std::invalid_argument) << wrong;
  EXPECT_THROW(parseAxes({}, {"/a.n=1,2; /b.m=4"}), std::invalid_argument);
  EXPECT_THROW(parseAxes({"dt=1,2"}, {"dt=3,4; /b.m=1,2"}), std::invalid_argument);
}

TEST(Axes, TolerancesAndIterationsHaveAnOrder) {
  const auto axes =
      parseAxes({"/s.tolerance=1e-2,1e-6,1e-4", "/s.iterations=100,10", "/s.method=b,a", "/s.tolerance2=x,y"}, {});
  EXPECT_EQ(axes[0].kind, AxisKind::tolerance);
  EXPECT_EQ(axes[0].finest(), 1u);
  EXPECT_EQ(axes[1].kind, AxisKind::iterations);
  EXPECT_EQ(axes[1].finest(), 0u);
  EXPECT_EQ(axes[2].kind, AxisKind::words);
  EXPECT_EQ(axes[2].finest(), 1u) << "of words the one listed last";
  EXPECT_EQ(axes[3].kind, AxisKind::words) << "no numbers";
}

}  // namespace
}  // namespace stroma::sweep
