// SPDX-License-Identifier: LGPL-2.1-or-later
// What panels are framed by: groups of bodies that are far apart, and what they are called.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/scene_fixture.h"
#include "tools/picture/frames.h"

namespace stroma::picture {
namespace {

using Groups = std::vector<std::vector<std::size_t>>;

/// A cube whose diagonal has the length 1.
Box cubeAt(const Vec3& corner) {
  Box box;
  box.add(corner), box.add(corner + Vec3::Constant(1 / std::sqrt(3.)));
  return box;
}
Box pointAt(const Vec3& place) {
  Box box;
  box.add(place);
  return box;
}

TEST(Frames, TheGapIsThatOfTheNearestCorners) {
  EXPECT_EQ(gapBetween(cubeAt({0, 0, 0}), cubeAt({0.1, 0.2, 0.3})), 0);
  const double side = 1 / std::sqrt(3.);
  EXPECT_NEAR(gapBetween(cubeAt({0, 0, 0}), cubeAt({3 + side, 4 + side, 0})), 5, 1e-12);
  EXPECT_NEAR(gapBetween(cubeAt({0, 0, 12 + side}), cubeAt({3 + side, 4 + side, 0})), 13, 1e-12);
}

TEST(Frames, BodiesPartWhereThereIsFiveTimesAsMuchRoomAsTheLargerNeeds) {
  const double side = 1 / std::sqrt(3.);
  EXPECT_EQ(groupsApart({cubeAt({0, 0, 0}), cubeAt({4.99 + side, 0, 0})}, {}), (Groups{{0, 1}}));
  EXPECT_EQ(groupsApart({cubeAt({0, 0, 0}), cubeAt({5.01 + side, 0, 0})}, {}), (Groups{{0}, {1}}));
  EXPECT_EQ(groupsApart({cubeAt({0, 0, 0}), cubeAt({1000, 0, 0}), cubeAt({2, 0, 0}), Box(), cubeAt({1001, 0, 0})}, {}),
            (Groups{{0, 2}, {1, 4}}));
  // the second is far from the first; both belong to what is between them
  EXPECT_EQ(groupsApart({cubeAt({0, 0, 0}), cubeAt({8, 0, 0}), cubeAt({4, 0, 0})}, {}), (Groups{{0, 1, 2}}));
}

TEST(Frames, WhatIsJoinedStaysTogetherAndPointsHaveTheSizeOfTheLargestBody) {
  EXPECT_EQ(groupsApart({cubeAt({0, 0, 0}), cubeAt({1000, 0, 0})}, {{1, 0}}), (Groups{{0, 1}}));
  EXPECT_EQ(groupsApart({cubeAt({0, 0, 0}), pointAt({4, 0, 0}), pointAt({1000, 0, 0})}, {}), (Groups{{0, 1}, {2}}));
  EXPECT_EQ(groupsApart({pointAt({0, 0, 0}), pointAt({1000, 0, 0})}, {}), (Groups{{0, 1}}))
      << "points alone have no size";
}

TEST(Frames, ManyGroupsAreOnePicture) {
  std::vector<Box> boxes;
  for (int i = 0; i < 4; ++i) boxes.push_back(cubeAt({100. * i, 0, 0}));
  EXPECT_EQ(groupsApart(boxes, {}).size(), 4u);
  boxes.push_back(cubeAt({1000, 0, 0}));
  EXPECT_EQ(groupsApart(boxes, {}), (Groups{{0, 1, 2, 3, 4}}));
}

TEST(Frames, GroupsAreCalledAfterTheNodeThatHoldsThem) {
  EXPECT_EQ(nameOfNodes({"/left"}), "left");
  EXPECT_EQ(nameOfNodes({"/left", "/left/skin"}), "left");
  EXPECT_EQ(nameOfNodes({"/a/b/c", "/a/b/d"}), "b");
  EXPECT_EQ(nameOfNodes({"/left", "/right"}), "left, right");
  EXPECT_EQ(nameOfNodes({"/a", "/b", "/c", "/d"}), "a, b and 2 more");
  EXPECT_EQ(nameOfNodes({"/"}), "/");
}

TEST(Frames, LengthsHaveThreeDigitsAndASuitableUnit) {
  EXPECT_EQ(lengthText(999.04, "m"), "999 m");
  EXPECT_EQ(lengthText(1000, "m"), "1000 m");
  EXPECT_EQ(lengthText(0.25, "m"), "250 mm");
  EXPECT_EQ(lengthText(0.0123456, "m"), "12.3 mm");
  EXPECT_EQ(lengthText(2000, "mm"), "2 m");
  EXPECT_EQ(lengthText(2.5, ""), "2.5");
}

TEST(Frames, ThoseAskedForAreTheBodiesBelowANode) {
  const std::string body =
      "<EulerImplicitSolver/><CGLinearSolver/><MechanicalObject position=\"0 0 0  1 0 0\"/><UniformMass "
      "totalMass=\"1\"/>";
  const Simulation simulation = test::simulationFromText("<Node name=\"root\"><Node name=\"a\">" + body +
                                                         "</Node><Node name=\"ab\">" + body + "</Node></Node>");
  PictureRequest request;
  const ShotTaker taker(simulation, request);
  const std::vector<Frame> frames = framesAsked(taker, {"/a", "/ab/", "/"});
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[0].name, "a");
  EXPECT_EQ(frames[0].bodies, (std::vector<std::size_t>{0}));
  EXPECT_EQ(frames[1].bodies, (std::vector<std::size_t>{1}));
  EXPECT_EQ(frames[2].name, "all");
  EXPECT_EQ(frames[2].bodies, (std::vector<std::size_t>{0, 1}));
  EXPECT_THROW(framesAsked(taker, {"/b"}), ComponentError);
}

}  // namespace
}  // namespace stroma::picture
