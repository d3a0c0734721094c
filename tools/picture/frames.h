// SPDX-License-Identifier: LGPL-2.1-or-later
// What the panels of a picture are framed by: all bodies, those of a node, or those of a group that is far from all others.
#pragma once
#include <array>
#include <limits>
#include <string>
#include <vector>

#include "framework/scene/types.h"
#include "tools/picture/shots.h"

namespace stroma::picture {

/// A box around places [m].
struct Box {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  void add(const Vec3& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); }
  void add(const Box& other) { low = low.cwiseMin(other.low), high = high.cwiseMax(other.high); }
  bool isEmpty() const { return !(low[0] <= high[0]); }
  Vec3 sides() const { return isEmpty() ? Vec3(Vec3::Zero()) : Vec3(high - low); }
  double size() const { return sides().norm(); }  ///< of its diagonal
};

/// The shortest way from one to the other; 0 where they overlap [m].
double gapBetween(const Box& a, const Box& b);

/// Groups of bodies, by the numbers of their boxes, that one picture cannot show well: between them is five times as much
/// room as the larger of two needs. One group of all where there are more than four, or only points. `joined`: pairs that
/// stay together. Empty boxes are in no group.
std::vector<std::vector<std::size_t>> groupsApart(const std::vector<Box>& boxes,
                                                  const std::vector<std::array<std::size_t, 2>>& joined);

/// The bodies that a panel is framed by.
struct Frame {
  std::string name{};  ///< for people; empty: all bodies
  std::vector<std::size_t> bodies{};
};

/// Of the paths that were asked for, a frame each. Throws ComponentError for a node without bodies that are drawn.
std::vector<Frame> framesAsked(const ShotTaker& taker, const std::vector<std::string>& paths);

/// Where bodies have been in all shots.
std::vector<Box> boxesOf(const ShotTaker& taker, const std::vector<Shot>& shots);

/// One frame of all bodies, or one for each group, where no more than `most` are.
std::vector<Frame> framesFound(const ShotTaker& taker, const std::vector<Box>& boxes, std::size_t most);

/// "left", or "left, right and 3 more": the node that holds all of these, or the nodes themselves.
std::string nameOfNodes(const std::vector<std::string>& paths);

/// "left and right are 1000 m apart".
std::string distanceBetween(const std::vector<Frame>& frames, const std::vector<Box>& boxes, const UnitSystem& units);

/// A length with three digits in a unit that suits it: "1.25 m".
std::string lengthText(double length, const std::string& unit);

}  // namespace stroma::picture
