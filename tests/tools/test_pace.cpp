// SPDX-License-Identifier: LGPL-2.1-or-later
// The time to go, of runs whose steps take times that are known.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "tools/command/pace.h"

namespace stroma::command {
namespace STROMA_TEST_FILE {

constexpr double look_every = 0.25;  // [s], as in a pipe

/// Looks at a run of which step i takes `seconds(i)`, and tells of each look: now, steps made, the pace.
void follow(long steps, const std::function<double(long)>& seconds,
            const std::function<void(double, long, const Pace&)>& tell) {
  Pace pace;
  double now = 0, ends = seconds(0);
  for (long made = 0; made < steps;) {
    now += look_every;
    while (made < steps && ends <= now) ends += ++made < steps ? seconds(made) : 0;
    pace.look(now, made);
    tell(now, made, pace);
  }
}

/// The first time at which a rest is told [s], and the worst ratio of the rest told to the true one from there on.
struct Told {
  double first = -1, least = std::numeric_limits<double>::infinity(), most = 0;
};

Told toldOf(long steps, const std::function<double(long)>& seconds) {
  double all = 0;
  for (long i = 0; i < steps; ++i) all += seconds(i);
  Told told;
  follow(steps, seconds, [&](double now, long made, const Pace& pace) {
    if (!pace.isSteady() || all - now < 1) return;
    if (told.first < 0) told.first = now;
    const double ratio = pace.secondsToGo(steps - made) / (all - now);
    told.least = std::min(told.least, ratio), told.most = std::max(told.most, ratio);
  });
  return told;
}

TEST(Pace, AnExpensiveFirstStepDoesNotCountForTheOthers) {
  const Told told = toldOf(5000, [](long i) { return i == 0 ? 30 : 0.01; });
  EXPECT_GE(told.first, 30);
  EXPECT_LE(told.first, 31);
  EXPECT_GT(told.least, 0.8);
  EXPECT_LT(told.most, 1.25);
}

TEST(Pace, EvenStepsAreToldOfSoonAndWell) {
  for (const double each : {0.0001, 0.01, 0.4, 3.0, 60.0}) {
    const Told told = toldOf(each < 0.1 ? 10000 : 40, [each](long) { return each; });
    EXPECT_LE(told.first, std::max(1.0, 4 * each + 1)) << each;
    EXPECT_GT(told.least, 0.7) << each;
    EXPECT_LT(told.most, 1.4) << each;
  }
}

TEST(Pace, NothingIsToldOfTheRestAfterOneStep) {
  follow(
      3, [](long) { return 10; },
      [](double now, long made, const Pace& pace) {
        EXPECT_EQ(pace.isKnown(), made >= 1) << now;
        EXPECT_EQ(pace.isSteady(), made >= 2) << now;
        if (made == 1) EXPECT_NEAR(pace.secondsPerStep(), std::max(10.0, now - 10), 0.26) << now;
      });
}

TEST(Pace, StepsThatBecomeSlowerAreNoticed) {
  // the second half is four times as slow: known once a third of the run so far is made of it
  double late = 0;
  follow(
      2000, [](long i) { return i < 1000 ? 0.01 : 0.04; },
      [&](double now, long made, const Pace& pace) {
        if (now > 40 && now < 48) late = std::max(late, std::abs(pace.secondsToGo(2000 - made) / (50 - now) - 1));
      });
  EXPECT_LT(late, 0.2);
}

/// A residual that falls by ten every two seconds, from 1 to the goal of 1e-8.
TEST(NewtonPace, TellsWhatIsLeftOfASteadyFall) {
  NewtonPace pace;
  EXPECT_LT(pace.secondsToGo(), 0) << "nothing is known";
  for (int iteration = 0; iteration <= 4; ++iteration) {
    pace.look(2.0 * iteration, 0, iteration, std::pow(10, -iteration), 1e-8);
    pace.look(2.0 * iteration + 0.5, 0, iteration, std::pow(10, -iteration), 1e-8);
    if (iteration == 0) {
      EXPECT_LT(pace.secondsToGo(), 0) << "one iterate tells no pace";
      continue;
    }
    EXPECT_NEAR(pace.secondsToGo(), 2.0 * (8 - iteration) - 0.5, 1e-9);
  }
}

TEST(NewtonPace, TellsNothingWhileTheResidualStays) {
  NewtonPace pace;
  for (int iteration = 0; iteration < 5; ++iteration) pace.look(iteration, 0, iteration, 0.1, 1e-8);
  EXPECT_LT(pace.secondsToGo(), 0);
}

TEST(NewtonPace, AnotherSolveBeginsAnew) {
  NewtonPace pace;
  pace.look(0, 0, 0, 1, 1e-8);
  pace.look(1, 0, 1, 0.1, 1e-8);
  EXPECT_GT(pace.secondsToGo(), 0);
  pace.look(2, 0, 0, 1, 1e-8);  // the next part of a divided step
  EXPECT_LT(pace.secondsToGo(), 0);
  pace.look(3, 0, 1, 0.1, 1e-8);
  pace.look(4, 1, 0, 1, 1e-8);  // the next step
  EXPECT_LT(pace.secondsToGo(), 0);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::command
