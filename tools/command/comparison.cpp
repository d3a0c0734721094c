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

std::string notFinite(const Frames& frames, const char* whose, const State& state) {
  for (const StateFrame& frame : frames)
    for (std::size_t i = 0; i < frame.x.size(); ++i)
      if (!frame.x[i].allFinite() || !frame.v[i].allFinite())
        return fmt::format("{} node {} at t = {:.6g} s is not finite: x = ({} {} {}), v = ({} {} {})", whose,
                           Index(i) / state.rows_per_node, frame.time, frame.x[i].x(), frame.x[i].y(), frame.x[i].z(),
                           frame.v[i].x(), frame.v[i].y(), frame.v[i].z());
  return {};
}

/// Rows of one kind: which they are, and what their errors are measured against.
struct OneKind {
  RowKind kind;
  const State& state;
  double size = 1, speed = 1;

  OneKind(RowKind of, const State& whose, const Frames& reference) : kind(of), state(whose) {
    Eigen::AlignedBox3d box;
    double fastest = 0;
    for (const StateFrame& frame : reference)
      each(frame.x.size(), [&](std::size_t i) { box.extend(frame.x[i]), fastest = std::max(fastest, frame.v[i].norm()); });
    if (kind != RowKind::turn && !box.isEmpty()) {
      const double range = box.diagonal().norm(), magnitude = kind == RowKind::value ? box.center().norm() : 0;
      size = range > 0 ? range : magnitude > 0 ? magnitude : 1;
    }
    const double duration = reference.back().time - reference.front().time;
    speed = std::max(fastest, duration > 0 ? size / duration : 0);
    if (speed == 0) speed = 1;
  }

  /// Calls visit(i) for each of these rows among `count`.
  template <class Visit>
  void each(std::size_t count, Visit&& visit) const {
    for (std::size_t i = 0; i < count; ++i)
      if (kind == state.kindOf(Index(i))) visit(i);
  }

  /// The L2 norm of the positions, of places about the centre of their box: a body far from the origin is not judged mildly.
  double norm(const std::vector<Vec3>& x) const {
    Eigen::AlignedBox3d box;
    std::size_t count = 0;
    each(x.size(), [&](std::size_t i) { box.extend(x[i]), ++count; });
    double sum = 0;
    if (kind == RowKind::place) each(x.size(), [&](std::size_t i) { sum += (x[i] - box.center()).squaredNorm(); });
    return sum > 0 ? std::sqrt(sum) : size * std::sqrt(double(count));
  }
};

/// The row that differs most at one instant.
struct Worst {
  double difference = 0;
  std::size_t row = 0, count = 0;
  double sum_of_squares = 0;
};

template <class Way>
Worst worstOf(const OneKind& rows, const std::vector<Vec3>& reference, const std::vector<Vec3>& actual, Way&& way) {
  Worst worst;
  rows.each(reference.size(), [&](std::size_t i) {
    const double difference = way(reference[i], actual[i]).norm();
    worst.sum_of_squares += difference * difference;
    if (difference > worst.difference || worst.count == 0) worst.difference = difference, worst.row = i;
    ++worst.count;
  });
  return worst;
}

std::string describe(const OneKind& rows, bool moving, double error, double tolerance, double time, const Worst& worst,
                     const std::vector<Vec3>& reference, const std::vector<Vec3>& actual) {
  const Vec3 &r = reference[worst.row], &a = actual[worst.row];
  const char* const what = rows.kind == RowKind::turn ? (moving ? "angular velocity" : "orientation (rotation vector)")
                           : rows.kind == RowKind::value ? (moving ? "rate" : "number")
                                                         : (moving ? "velocity" : "position");
  return fmt::format(
      "{} differs by {:.3g} (tolerance {:.3g}) at t = {:.6g} s, most at node {}: ({:.9g} {:.9g} {:.9g}), reference "
      "({:.9g} {:.9g} {:.9g})",
      what, error, tolerance, time, Index(worst.row) / rows.state.rows_per_node, a.x(), a.y(), a.z(), r.x(), r.y(), r.z());
}

void compareRows(const OneKind& rows, const StateFrame& r, const StateFrame& a, double tolerance, Comparison& result) {
  const auto way = [&](const Vec3& from, const Vec3& to) { return wayBetween(rows.kind, from, to); };
  const auto change = [](const Vec3& from, const Vec3& to) { return Vec3(to - from); };
  const Worst x = worstOf(rows, r.x, a.x, way), v = worstOf(rows, r.v, a.v, change);
  if (x.count == 0) return;
  const double x_max = x.difference / rows.size, v_max = v.difference / rows.speed;
  const double x_l2 = std::sqrt(x.sum_of_squares) / rows.norm(r.x);
  const double v_l2 = std::sqrt(v.sum_of_squares / double(v.count)) / rows.speed;
  result.position_error = std::max(result.position_error, x_max);
  result.position_l2_error = std::max(result.position_l2_error, x_l2);
  result.velocity_error = std::max(result.velocity_error, v_max);
  result.velocity_l2_error = std::max(result.velocity_l2_error, v_l2);
  if (!result.failure.empty()) return;
  if (!(std::max(x_max, x_l2) <= tolerance))
    result.failure = describe(rows, false, std::max(x_max, x_l2), tolerance, r.time, x, r.x, a.x);
  else if (!(std::max(v_max, v_l2) <= tolerance))
    result.failure = describe(rows, true, std::max(v_max, v_l2), tolerance, r.time, v, r.v, a.v);
}

}  // namespace

Comparison compare(const Frames& reference, const Frames& actual, double tolerance, const State& state) {
  Comparison result;
  result.failure = mismatch(reference, actual);
  if (result.failure.empty()) result.failure = notFinite(reference, "reference", state);
  if (result.failure.empty()) result.failure = notFinite(actual, "computed", state);
  if (!result.failure.empty()) return result;

  const OneKind kinds[] = {{RowKind::place, state, reference}, {RowKind::turn, state, reference}, {RowKind::value, state, reference}};
  for (std::size_t i = 0; i < reference.size(); ++i)
    for (const OneKind& rows : kinds) compareRows(rows, reference[i], actual[i], tolerance, result);
  result.passed = result.failure.empty();
  return result;
}

}  // namespace stroma::command
