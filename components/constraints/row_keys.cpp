// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/constraints/row_keys.h"

#include <fmt/format.h>

#include <cmath>

#include "framework/mechanics/motion.h"

namespace stroma {

namespace {

bool areNumbers(const State& state) { return state.kindOf(0) == RowKind::value; }
std::size_t numbersOf(const State& state) { return std::size_t(state.rows_per_node) * (areNumbers(state) ? 1 : 3); }

std::string describeNumbers(const State& state) {
  return areNumbers(state)    ? fmt::format("{}, one for each number of a node", state.rows_per_node)
         : state.hasFrames() ? "6: for x, y, z and the turns about them"
                             : "3: for x, y, z";
}

}  // namespace

void RowKeys::declare(DataTable& table, const std::string& name, const std::string& help, const std::string& unit) {
  name_ = name;
  table.add("keyTimes", times_).help("times, ascending").unit("s").required();
  table.add(name, numbers_).help(help + "; six numbers of a rigid frame, one of a number").unit(unit).required();
}

void RowKeys::compile(const State& state) {
  const std::size_t each = numbersOf(state), keys = numbers_.size() / each;
  if (numbers_.size() % each != 0)
    throw ComponentError(fmt::format("{} has {} numbers", name_, numbers_.size()),
                         fmt::format("for each of keyTimes {}", describeNumbers(state)));
  keys_.assign(std::size_t(state.rows_per_node), {});
  for (std::size_t k = 0; k < keys_.size(); ++k) {
    std::vector<Vec3> values;
    for (std::size_t i = 0; i < keys; ++i) {
      const double* at = numbers_.data() + i * each + k * (areNumbers(state) ? 1 : 3);
      values.push_back(areNumbers(state) ? Vec3(*at, 0, 0) : Vec3(at[0], at[1], at[2]));
    }
    keys_[k].assign(times_, std::move(values), "keyTimes", name_);
    keys_[k].check();
  }
}

Quaternion RowKeys::turn(Index k, const Mat3& held, double a, double b) const {
  Quaternion turned = Quaternion::Identity();
  double from = a;
  const auto go = [&](double to) {
    const Vec3 w0 = held * of(k).at(from), w1 = held * of(k).at(to);
    const int steps = w0.cross(w1).norm() <= 1e-14 * w0.norm() * w1.norm() ? 1 : 64;
    const double h = (to - from) / steps;
    for (int i = 0; i < steps; ++i) {
      const Vec3 u0 = w0 + double(i) / steps * (w1 - w0), u1 = w0 + double(i + 1) / steps * (w1 - w0);
      turned = turnedBy(h * (u0 + u1) / 2 - h * h / 12 * u0.cross(u1)) * turned;
    }
    from = to;
  };
  for (const double key : times_)
    if (key > from && key < b) go(key);
  go(b);
  return turned;
}

void noteRows(const State& state, Index node, ConstRows x, std::vector<Vec3>& out) {
  for (Index k = 0; k < state.rows_per_node; ++k)
    out.push_back(valueOfRow(state.kindOf(node + k), x, state.firstRow() + node + k));
}

Vec3 angularVelocity(const Vec3& r, const Vec3& rate) {
  const double s = r.squaredNorm(), angle = std::sqrt(s);
  const bool small = angle < 0.1;
  const double a = small ? 0.5 - s * (1. / 24 - s * (1. / 720 - s / 40320)) : (1 - std::cos(angle)) / s;
  const double b = small ? 1. / 6 - s * (1. / 120 - s * (1. / 5040 - s / 362880)) : (angle - std::sin(angle)) / (s * angle);
  const Vec3 once = r.cross(rate);
  return rate + a * once + b * r.cross(once);
}

void moveHeld(RowKind kind, const Vec3& value, const Mat3& held, Rows x, Index row) {
  if (kind != RowKind::turn) return void(x[row] += held * (value - x[row]));
  const Vec3 way = rotationVector(turnedBy(value) * orientationIn(x, row).conjugate());
  Motion::turnBy(held * way, x.data + std::size_t(row) * row_doubles);
}

std::vector<Mat3> freeDirections(const std::vector<bool>& held, const State& state, const std::string& attribute) {
  if (held.size() != numbersOf(state))
    throw ComponentError(fmt::format("{} has {} values", attribute, held.size()), describeNumbers(state));
  std::vector<Mat3> free(std::size_t(state.rows_per_node), Mat3::Zero());
  for (std::size_t i = 0; i < held.size(); ++i) {
    const Index c = areNumbers(state) ? 0 : Index(i % 3);
    free[areNumbers(state) ? i : i / 3](c, c) = held[i] ? 0 : 1;
  }
  return free;
}

}  // namespace stroma
