// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/comparison.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace stroma::command {
namespace {

using Frames = std::vector<StateFrame>;

/// The first thing that makes numbers incomparable, or empty.
std::string mismatch(const Frames& reference, const Frames& actual) {
  if (reference.empty()) return "the reference holds no instant";
  if (reference.size() != actual.size())
    return fmt::format("{} frames, the reference has {}", actual.size(), reference.size());
  const double duration = std::abs(reference.back().time - reference.front().time);
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const StateFrame &r = reference[i], &a = actual[i];
    // written so that a time that is not a number fails
    if (!(std::abs(r.time - a.time) <= 1e-9 * std::max(duration, std::abs(r.time))))
      return fmt::format("instant {} is at t = {:.9g} s, in the reference at {:.9g} s", i, a.time, r.time);
    if (r.x.empty() || r.x.size() != a.x.size() || r.v.size() != a.v.size() || a.v.size() != a.x.size())
      return fmt::format("t = {:.6g} s: {} positions and {} velocities, in the reference {} and {}", a.time, a.x.size(),
                         a.v.size(), r.x.size(), r.v.size());
  }
  return {};
}

std::string notFinite(const Frames& frames, const char* whose) {
  for (const StateFrame& frame : frames)
    for (std::size_t i = 0; i < frame.x.size(); ++i)
      if (!frame.x[i].allFinite() || !frame.v[i].allFinite())
        return fmt::format("{} node {} at t = {:.6g} s is not finite: x = ({} {} {}), v = ({} {} {})", whose, i,
                           frame.time, frame.x[i].x(), frame.x[i].y(), frame.x[i].z(), frame.v[i].x(), frame.v[i].y(),
                           frame.v[i].z());
  return {};
}

Eigen::AlignedBox3d boxOf(const std::vector<Vec3>& points) {
  Eigen::AlignedBox3d box;
  for (const Vec3& point : points) box.extend(point);
  return box;
}

/// What errors are measured against.
struct Scales {
  double length = 0, velocity = 0;
  explicit Scales(const Frames& reference) {
    Eigen::AlignedBox3d box;
    double fastest = 0;
    for (const StateFrame& frame : reference) {
      box.extend(boxOf(frame.x));
      for (const Vec3& v : frame.v) fastest = std::max(fastest, v.norm());
    }
    length = box.diagonal().norm() > 0 ? box.diagonal().norm() : 1;
    const double duration = reference.back().time - reference.front().time;
    velocity = std::max(fastest, duration > 0 ? length / duration : 0);
    if (velocity == 0) velocity = 1;
  }
};

/// The node that differs most at one instant.
struct Worst {
  double difference = -1;
  std::size_t node = 0;
  double sum_of_squares = 0;
};

Worst worstOf(const std::vector<Vec3>& reference, const std::vector<Vec3>& actual) {
  Worst worst;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const double difference = (actual[i] - reference[i]).norm();
    worst.sum_of_squares += difference * difference;
    if (difference > worst.difference) worst.difference = difference, worst.node = i;
  }
  return worst;
}

/// The size of the positions about the centre of their box, so that a body far from the origin is not judged mildly.
double normAboutCentre(const std::vector<Vec3>& points, double length) {
  const Vec3 centre = boxOf(points).center();
  double sum = 0;
  for (const Vec3& point : points) sum += (point - centre).squaredNorm();
  return sum > 0 ? std::sqrt(sum) : length * std::sqrt(double(points.size()));
}

std::string describe(const char* what, double error, double tolerance, const StateFrame& frame, const Worst& worst,
                     const std::vector<Vec3>& reference, const std::vector<Vec3>& actual) {
  const Vec3 &r = reference[worst.node], &a = actual[worst.node];
  return fmt::format(
      "{} differs by {:.3g} (tolerance {:.3g}) at t = {:.6g} s, most at node {}: ({:.9g} {:.9g} {:.9g}), reference "
      "({:.9g} {:.9g} {:.9g})",
      what, error, tolerance, frame.time, worst.node, a.x(), a.y(), a.z(), r.x(), r.y(), r.z());
}

}  // namespace

Comparison compare(const Frames& reference, const Frames& actual, double tolerance) {
  Comparison result;
  result.failure = mismatch(reference, actual);
  if (result.failure.empty()) result.failure = notFinite(reference, "reference");
  if (result.failure.empty()) result.failure = notFinite(actual, "computed");
  if (!result.failure.empty()) return result;

  const Scales scale(reference);
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const StateFrame &r = reference[i], &a = actual[i];
    const Worst x = worstOf(r.x, a.x), v = worstOf(r.v, a.v);
    const double x_max = x.difference / scale.length, v_max = v.difference / scale.velocity;
    const double x_l2 = std::sqrt(x.sum_of_squares) / normAboutCentre(r.x, scale.length);
    const double v_l2 = std::sqrt(v.sum_of_squares / double(r.v.size())) / scale.velocity;
    result.position_error = std::max(result.position_error, x_max);
    result.position_l2_error = std::max(result.position_l2_error, x_l2);
    result.velocity_error = std::max(result.velocity_error, v_max);
    result.velocity_l2_error = std::max(result.velocity_l2_error, v_l2);
    if (!result.failure.empty()) continue;
    if (!(std::max(x_max, x_l2) <= tolerance))
      result.failure = describe("position", std::max(x_max, x_l2), tolerance, r, x, r.x, a.x);
    else if (!(std::max(v_max, v_l2) <= tolerance))
      result.failure = describe("velocity", std::max(v_max, v_l2), tolerance, r, v, r.v, a.v);
  }
  result.passed = result.failure.empty();
  return result;
}

}  // namespace stroma::command
