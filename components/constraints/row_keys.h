// SPDX-License-Identifier: LGPL-2.1-or-later
// Movements and velocities that are given at key times, of points, rigid frames and numbers.
#pragma once
#include <string>
#include <vector>

#include "framework/mechanics/frames.h"
#include "framework/mechanics/key_times.h"

namespace stroma {

/// Linear between key times; at each of them three numbers of a point, six of a frame (of its centre, and a rotation vector or
/// an angular velocity in fixed axes), one for each number of other nodes.
class RowKeys {
 public:
  /// Declares keyTimes and `name`.
  void declare(DataTable& table, const std::string& name, const std::string& help, const std::string& unit);
  /// For the nodes of a state, once they are known. Throws ComponentError where the numbers do not fit them.
  void compile(const State& state);
  double first() const { return keys_[0].first(); }  ///< [s]
  double last() const { return keys_[0].last(); }    ///< [s]
  bool touches(double t, double t_end) const { return keys_[0].touches(t, t_end); }
  /// Of row `k` of a node: a vector of which a number has x.
  const KeyTimes<Vec3>& of(Index k) const { return keys_[std::size_t(k)]; }
  /// How a frame turns from a to b [s] with the angular velocity w of row `k`, as far as `held` lets it through: exact where w
  /// keeps its direction between keys,
  /// else by steps of exp(h (w0 + w1)/2 - h^2 w0 x w1/12) (Magnus 1954, of fourth order).
  Quaternion turn(Index k, const Mat3& held, double a, double b) const;

 private:
  std::string name_;
  std::vector<double> times_{}, numbers_{};  ///< as written
  std::vector<KeyTimes<Vec3>> keys_;         ///< shape (rows of a node)
};

/// The values of the rows of a node (given by its first row) in x, as State::position has them, appended to `out`.
void noteRows(const State& state, Index node, ConstRows x, std::vector<Vec3>& out);

/// The angular velocity of exp(r(t)) with r' = rate: dexp(r) r', dexp(r) = I + (1 - cos|r|)/|r|^2 [r] + (|r| - sin|r|)/|r|^3 [r]^2
Vec3 angularVelocity(const Vec3& r, const Vec3& rate);

/// Row `row` of x goes to `value` (as State::position has it) in the directions that `held` projects onto.
void moveHeld(RowKind kind, const Vec3& value, const Mat3& held, Rows x, Index row);

/// The directions that a list of words asks for: of each row of a node the projector onto those that are free. Three of a
/// point, six of a frame, one of each number. Throws ComponentError for a list of another size; `attribute`: its name.
std::vector<Mat3> freeDirections(const std::vector<bool>& held, const State& state, const std::string& attribute);

}  // namespace stroma
