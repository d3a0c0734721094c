// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/picture/frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "framework/scene/diagnostics.h"
#include "tools/picture/legend.h"

namespace stroma::picture {
namespace {

constexpr double far_apart = 5;  // times the larger of two groups: the room between them
constexpr std::size_t most_groups = 4, most_boxes = 300;

struct Cluster {
  Box box{};
  double size = 0;
  std::vector<std::size_t> members{};
};

bool areTogether(const Cluster& a, const Cluster& b) {
  return gapBetween(a.box, b.box) <= far_apart * std::max(a.size, b.size);
}

/// The second joins the first.
void merge(std::vector<Cluster>& clusters, std::size_t a, std::size_t b) {
  Cluster& into = clusters[a];
  into.box.add(clusters[b].box);
  into.size = std::max({into.size, clusters[b].size, into.box.size()});
  into.members.insert(into.members.end(), clusters[b].members.begin(), clusters[b].members.end());
  clusters.erase(clusters.begin() + long(b));
}

void mergeJoined(std::vector<Cluster>& clusters, const std::vector<std::array<std::size_t, 2>>& joined) {
  const auto with = [&clusters](std::size_t box) {
    return std::size_t(std::find_if(clusters.begin(), clusters.end(),
                                    [box](const Cluster& one) {
                                      return std::find(one.members.begin(), one.members.end(), box) !=
                                             one.members.end();
                                    }) -
                       clusters.begin());
  };
  for (const auto& [i, j] : joined) {
    const std::size_t a = with(i), b = with(j);
    if (a != b && a < clusters.size() && b < clusters.size()) merge(clusters, std::min(a, b), std::max(a, b));
  }
}

std::vector<std::string> namesIn(const std::string& path) {
  std::vector<std::string> names;
  std::istringstream stream(path);
  for (std::string name; std::getline(stream, name, '/');)
    if (!name.empty()) names.push_back(name);
  return names;
}

}  // namespace

double gapBetween(const Box& a, const Box& b) {
  return Vec3((a.low - b.high).cwiseMax(b.low - a.high).cwiseMax(Vec3::Zero())).norm();
}

std::vector<std::vector<std::size_t>> groupsApart(const std::vector<Box>& boxes,
                                                  const std::vector<std::array<std::size_t, 2>>& joined) {
  std::vector<Cluster> clusters;
  std::vector<std::size_t> all;
  double largest = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (boxes[i].isEmpty()) continue;
    clusters.push_back({boxes[i], boxes[i].size(), {i}});
    all.push_back(i);
    largest = std::max(largest, boxes[i].size());
  }
  if (largest == 0 || clusters.size() > most_boxes) return {all};
  for (Cluster& cluster : clusters)
    if (cluster.size == 0) cluster.size = largest;  // a point is seen at any scale
  mergeJoined(clusters, joined);
  for (bool merged = true; merged;) {
    merged = false;
    for (std::size_t a = 0; a < clusters.size(); ++a)
      for (std::size_t b = a + 1; b < clusters.size();)
        if (areTogether(clusters[a], clusters[b]))
          merge(clusters, a, b), merged = true;
        else
          ++b;
  }
  if (clusters.size() > most_groups) return {all};
  std::vector<std::vector<std::size_t>> groups;
  for (Cluster& cluster : clusters) {
    std::sort(cluster.members.begin(), cluster.members.end());
    groups.push_back(cluster.members);
  }
  std::sort(groups.begin(), groups.end());
  return groups;
}

std::string nameOfNodes(const std::vector<std::string>& paths) {
  std::vector<std::string> common = namesIn(paths.front()), names;
  for (const std::string& path : paths) {
    const std::vector<std::string> own = namesIn(path);
    const auto ends = std::mismatch(common.begin(), common.end(), own.begin(), own.end());
    common.erase(ends.first, common.end());
    const std::string last = own.empty() ? "/" : own.back();
    if (std::find(names.begin(), names.end(), last) == names.end()) names.push_back(last);
  }
  if (!common.empty()) return common.back();
  if (names.size() < 3) return fmt::format("{}", fmt::join(names, ", "));
  return fmt::format("{}, {} and {} more", names[0], names[1], names.size() - 2);
}

std::vector<Frame> framesAsked(const ShotTaker& taker, const std::vector<std::string>& paths) {
  std::vector<Frame> frames;
  for (const std::string& path : paths) {
    Frame frame{path, {}};
    for (const std::size_t b : taker.bodiesAt(path, "framed"))
      if (taker.isDrawn(b)) frame.bodies.push_back(b);
    if (frame.bodies.empty())
      throw ComponentError(fmt::format("nothing of {} is drawn: it cannot be used for --frame", path),
                           "a node that is not hidden");
    const std::vector<std::string> names = namesIn(path);
    frame.name = names.empty() ? "all" : names.back();
    frames.push_back(std::move(frame));
  }
  return frames;
}

std::vector<Box> boxesOf(const ShotTaker& taker, const std::vector<Shot>& shots) {
  std::vector<Box> boxes(taker.drawing().bodies.size());
  for (const Shot& shot : shots)
    for (std::size_t b = 0; b < boxes.size(); ++b) {
      const Points& x = shot.bodies[b].x;
      for (std::size_t i = 0; i + 2 < x.size(); i += 3) boxes[b].add(Vec3(x[i], x[i + 1], x[i + 2]));
      for (const drawing::Ball& ball : taker.drawing().bodies[b].balls) {
        const std::size_t i = 3 * std::size_t(ball.node);
        if (i + 2 >= x.size()) continue;
        for (const double side : {-ball.radius, ball.radius})
          boxes[b].add(Vec3(x[i] + side, x[i + 1] + side, x[i + 2] + side));
      }
    }
  return boxes;
}

std::vector<Frame> framesFound(const ShotTaker& taker, const std::vector<Box>& boxes, std::size_t most) {
  std::vector<std::array<std::size_t, 2>> joined;
  for (const drawing::BodyLink& link : taker.drawing().links)
    joined.push_back({std::size_t(link.body_a), std::size_t(link.body_b)});
  const auto groups = groupsApart(boxes, joined);
  if (groups.size() < 2 || groups.size() > most) {
    Frame whole;
    for (std::size_t b = 0; b < boxes.size(); ++b)
      if (taker.isDrawn(b)) whole.bodies.push_back(b);
    return {whole};
  }
  std::vector<Frame> frames;
  for (const std::vector<std::size_t>& group : groups) {
    std::vector<std::string> paths;
    for (const std::size_t b : group) paths.push_back(taker.drawing().bodies[b].state->node().path());
    frames.push_back({nameOfNodes(paths), group});
  }
  return frames;
}

std::string distanceBetween(const std::vector<Frame>& frames, const std::vector<Box>& boxes, const UnitSystem& units) {
  std::vector<Box> around(frames.size());
  for (std::size_t f = 0; f < frames.size(); ++f)
    for (const std::size_t b : frames[f].bodies) around[f].add(boxes[b]);
  double longest = 0;
  for (std::size_t f = 0; f < frames.size(); ++f)
    for (std::size_t g = 0; g < f; ++g) longest = std::max(longest, gapBetween(around[f], around[g]));
  const std::string length = lengthText(longest, units.unit("m"));
  return frames.size() == 2 ? fmt::format("{} and {} are {} apart", frames[0].name, frames[1].name, length)
                            : fmt::format("the bodies are up to {} apart", length);
}

std::string lengthText(double length, const std::string& unit) {
  const Scale scale = scaleFor(length, unit);
  double shown = length / scale.factor;
  if (shown > 0) {
    const double last = std::pow(10., std::floor(std::log10(shown)) - 2);  // of three digits
    shown = last * std::round(shown / last);
  }
  return fmt::format("{:g}{}{}", shown, scale.unit.empty() ? "" : " ", scale.unit);
}

}  // namespace stroma::picture
