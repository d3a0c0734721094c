// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/stress/force_checks.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "framework/mechanics/state_positions.h"
#include "framework/mechanics/state_topology.h"
#include "tools/checks/folds.h"
#include "tools/stress/disturbance.h"

namespace stroma::stress {
namespace {

constexpr int directions = 3;
/// Relative differences that are more than those of the difference quotients and of round-off.
constexpr double exact = 0.01, rough = 0.25;
constexpr double same = 1e-8;  ///< of two ways to one result

/// One force field on the rows of its system.
class FieldCheck {
 public:
  FieldCheck(System& system, ForceField& field, unsigned seed)
      : system_(system),
        field_(field),
        random_(seed),
        size_(sizeOf(system)),
        x_(system.allRows()),
        v_(system.allRows()),
        force_(system.allRows()),
        other_(system.allRows()),
        product_(system.allRows()),
        direction_(system.allRows()) {
    copy(system.x, x_);
  }

  std::vector<std::string> operator()(bool near_start) {
    forceAt(0, force_);
    if (!isFinite(force_)) {
      if (field_.worstElement(x_).empty()) say("the force is no number, and no element is to blame");
      return found_;
    }
    checkRepeats();
    checkBalance();
    checkInversion();
    for (int k = 0; k < directions; ++k) {
      choose(k == 0);
      checkEnergy();
      checkDerivative(near_start);
      checkDamping(near_start);
    }
    checkMatrix();
    forceAt(0, other_);  // what is prepared belongs to these positions again
    return found_;
  }

 private:
  double sign() { return double(random_()) / 2147483648. - 1; }

  /// The force at x + h direction.
  void forceAt(double h, Vector& out) {
    Vector x(system_.allRows());
    copy(x_, x);
    if (h != 0) system_.motion().advance(h, direction_, x);
    clear(out);
    field_.addForce(x, v_, out);
  }
  double energyAt(double h) {
    Vector x(system_.allRows());
    copy(x_, x);
    if (h != 0) system_.motion().advance(h, direction_, x);
    return field_.energy(x);
  }
  static bool isFinite(ConstRows rows) {
    for (std::size_t i = 0; i < rows.doubles(); ++i)
      if (!std::isfinite(rows.data[i])) return false;
    return true;
  }
  void say(const std::string& what) {
    const std::string sentence =
        fmt::format("{}: {} ({}): {}", field_.where().text(), field_.path(), field_.type(), what);
    if (std::find(found_.begin(), found_.end(), sentence) == found_.end()) found_.push_back(sentence);
  }

  /// A direction of length 1 with the places and numbers of the field's states; the first is that of the force, in which
  /// nothing is small.
  void choose(bool along_force) {
    clear(direction_);
    for (const State* state : field_.states())
      for (Index i = 0; i < state->size(); ++i) {
        const Index row = state->firstRow() + i;
        const double a = sign(), b = sign(), c = sign();
        if (state->kindOf(i) == RowKind::place) direction_[row] = Vec3(a, b, c);
        if (state->kindOf(i) == RowKind::value) direction_[row] = Vec3(a, 0, 0);
      }
    if (along_force && norm(force_) > 0)
      for (const State* state : field_.states())
        for (Index i = 0; i < state->size(); ++i)
          if (state->kindOf(i) != RowKind::turn)
            direction_[state->firstRow() + i] = Vec3(force_[state->firstRow() + i]) / norm(force_);
    if (const double length = norm(direction_); length > 0) scale(1 / length, direction_);
  }

  void checkRepeats() {
    choose(false);
    forceAt(1e-3 * size_, other_);
    forceAt(0, other_);
    for (std::size_t i = 0; i < other_.rows().doubles(); ++i)
      if (!(other_.rows().data[i] == force_.rows().data[i]))
        return say("equal positions give different forces: it depends on earlier computations");
  }

  void checkBalance() {
    const ForceTraits traits = field_.traits();
    Vec3 sum = Vec3::Zero(), torque = Vec3::Zero();
    double sizes = 0, arms = 0;
    for (const State* state : field_.states())
      for (Index i = 0; i < state->size(); ++i) {
        if (state->kindOf(i) != RowKind::place) return;
        const Vec3 f = force_[state->firstRow() + i], x = x_[state->firstRow() + i];
        sum += f;
        torque += x.cross(f);
        sizes += f.norm();
        arms += x.norm() * f.norm();
      }
    if (traits.forces_balance && sum.norm() > 1e-7 * sizes)
      say(fmt::format("its forces should balance, and their sum is {:.2g} of their sizes", sum.norm() / sizes));
    if (traits.torques_balance && torque.norm() > 1e-7 * arms)
      say(fmt::format("its torques should balance, and their sum is {:.2g} of their sizes", torque.norm() / arms));
  }

  /// f . d = -dE/dd. Differences of energies have few digits: with steps of a share of the size, and what round-off leaves.
  void checkEnergy() {
    if (!field_.traits().conservative) return;
    const double power = dot(force_, direction_), h = 1e-5 * size_;
    const double energy = field_.energy(x_);
    if (!std::isfinite(energy)) return say("its energy is no number where its force is one");
    double bend[2] = {};  // twice the difference of the slopes on the two sides
    const auto slope = [&](double step, double& bend_of) {
      const double ahead = energyAt(step), behind = energyAt(-step);
      bend_of = std::abs(ahead - 2 * energy + behind) / step;
      return -(ahead - behind) / (2 * step);
    };
    const double wide = slope(h, bend[0]), narrow = slope(h / 4, bend[1]);
    if (!std::isfinite(wide) || !std::isfinite(narrow)) return;
    const double scale_of = std::max(std::abs(power), std::abs(narrow));
    const double round_off = 1e-15 * std::abs(energy) / h * 16;
    if (scale_of == 0 || round_off > 0.1 * exact * scale_of) return;
    if (std::abs(wide - narrow) > exact * scale_of) return;  // a kink
    // one right here: the slopes of a smooth energy differ by a quarter of it at a quarter of the step
    if (bend[1] > exact * scale_of && bend[1] > 0.5 * bend[0]) return;
    if (std::abs(power - narrow) > 3 * exact * scale_of)
      say(fmt::format("the force is not the slope of its energy: {:.6g} N where the energy falls by {:.6g} J/m", power,
                      narrow));
  }

  void checkDerivative(bool near_start) {
    const ForceTraits traits = field_.traits();
    if (!traits.has_stiffness || traits.lagged || (!traits.exact_tangent && !near_start)) return;
    Vector wide(system_.allRows()), narrow(system_.allRows());
    const double h = 1e-5 * size_;
    difference(h, wide);
    difference(h / 4, narrow);
    forceAt(0, other_);
    clear(product_);
    field_.addStiffnessProduct(direction_, 1, product_);
    compareProduct("stiffness", wide, narrow, h);
  }
  void difference(double h, Vector& out) {
    forceAt(h, out);
    forceAt(-h, other_);
    axpy(-1, other_, out);
    scale(1 / (2 * h), out);
  }

  /// The same for velocities, at rest.
  void checkDamping(bool near_start) {
    const ForceTraits traits = field_.traits();
    if (!traits.velocity_dependent || (!traits.exact_tangent && !near_start)) return;
    Vector wide(system_.allRows()), narrow(system_.allRows());
    const double h = 1e-4 * size_;  // a second is as good as any time
    for (const double step : {h, h / 4}) {
      Vector& out = step == h ? wide : narrow;
      forceMoving(step, out);
      forceMoving(-step, other_);
      axpy(-1, other_, out);
      scale(1 / (2 * step), out);
    }
    forceAt(0, other_);
    clear(product_);
    field_.addDampingProduct(direction_, 1, product_);
    compareProduct("damping", wide, narrow, h);
  }
  void forceMoving(double speed, Vector& out) {
    Vector v(system_.allRows());
    axpy(speed, direction_, v);
    clear(out);
    field_.addForce(x_, v, out);
  }

  /// product_ against two central differences, the narrow one of a quarter of h.
  void compareProduct(const char* what, ConstRows wide, ConstRows narrow, double h) {
    const ForceTraits traits = field_.traits();
    if (!isFinite(product_)) return say(fmt::format("its {} is no number where its force is one", what));
    if (!isFinite(wide) || !isFinite(narrow)) return;
    const double scale_of = std::max(norm(narrow), norm(product_));
    const double round_off = 1e-15 * norm(force_) / h * 16;
    if (scale_of == 0 || round_off > 0.1 * exact * scale_of) return;
    if (distance(wide, narrow) > exact * scale_of) return;
    const double error = distance(product_, narrow) / scale_of;
    const double cosine = dot(product_, narrow) / (norm(product_) * norm(narrow));
    // a load may leave half of its derivative out, so that the matrix is symmetric; inside a body more is known
    const bool is_rough = traits.forces_balance ? error > rough : cosine < -0.5;
    if (traits.exact_tangent ? !(error > 3 * exact) : !is_rough) return;
    say(fmt::format("its {} is not the derivative of its force: the error is {:.2g}{}", what, error,
                    cosine < -0.5 ? ", and of the other sign" : ""));
  }

  /// There are three more ways to the same stiffness. Solvers that assemble see none of the product.
  void checkMatrix() {
    if (!field_.traits().has_stiffness) return;
    const Index rows = system_.allRows();
    forceAt(0, other_);
    clear(product_);
    field_.addStiffnessProduct(direction_, 1, product_);
    BlockPattern pattern(rows);
    field_.addPattern(pattern);
    BlockMatrix matrix(std::move(pattern));
    field_.prepareAssembly(matrix);
    field_.addStiffness(1, matrix);
    matrix.multiply(direction_, other_);
    if (!(distance(other_, product_) <= same * norm(product_)))
      say(fmt::format("its matrix does not match its product: error {:.2g}",
                      distance(other_, product_) / norm(product_)));
    std::vector<double> diagonal(std::size_t(rows) * 9, 0.);
    field_.addStiffnessDiagonal(1, diagonal);
    double worst = 0, sizes = 0;
    for (std::size_t i = 0; i < diagonal.size(); ++i) {
      const double value = matrix.values()[std::size_t(matrix.diagonal()[i / 9]) * 9 + i % 9];
      worst += std::abs(value - diagonal[i]), sizes += std::abs(value);
    }
    if (!(worst <= same * sizes))
      say(fmt::format("its diagonal does not match its matrix: error {:.2g}", worst / sizes));
    clear(other_);
    field_.addForceAndProduct(x_, v_, direction_, 0.5, other_);
    axpy(-1, force_, other_);
    axpy(-0.5, product_, other_);
    const double both = norm(force_) + norm(product_);
    if (!(norm(other_) <= same * both))
      say(fmt::format("force and product in one pass differ from the two separately: error {:.2g}", norm(other_) / both));
  }

  /// A field that has volumes knows those that are inside out. The mesh says which are.
  void checkInversion() {
    const std::vector<std::string> names = field_.cellFields();
    if (std::find(names.begin(), names.end(), "J") == names.end()) return;
    std::vector<double> j;
    field_.cellField("J", x_, j);
    if (j.empty() || std::any_of(j.begin(), j.end(), [](double value) { return !(value > 0); })) return;
    const State& state = field_.state();
    for (const Topology* topology : topologiesOf(state)) {
      const auto [inverted, all] = insideOutCells(topology->mesh(), state.rest_position, positionsOf(state, x_));
      // fields may have other cells than this mesh, and points inside a cell do not see its corners
      if (all == 0 || 2 * inverted < all || j.size() < all) continue;
      say(fmt::format("{} of {} cells are inside out, and its J is positive in all: it does not see inversion",
                      inverted, all));
    }
  }

  System& system_;
  ForceField& field_;
  std::mt19937 random_;
  double size_;
  Vector x_, v_, force_, other_, product_, direction_;
  std::vector<std::string> found_;
};

/// The chain of mappings of a system, as one function of its independent rows.
std::vector<std::string> brokenMappings(System& system, unsigned seed) {
  const auto& mappings = system.actors().mappings;
  if (mappings.empty()) return {};
  std::mt19937 random(seed);
  const Index all = system.allRows(), independent = system.independentRows();
  const double h = 1e-6 * sizeOf(system);
  Vector d(all), ahead(all), behind(all), f(all);
  for (Index row = 0; row < all; ++row)
    for (int c = 0; c < 3; ++c) {
      const double number = double(random()) / 2147483648. - 1;
      const bool has = system.motion().kindOf(row) != RowKind::value || c == 0;
      (row < independent ? d : f)[row][c] = has ? number : 0;
    }
  for (const double step : {h, -h}) {
    Vector& x = step > 0 ? ahead : behind;
    copy(system.x, x);
    system.motion().advance(step, std::as_const(d).head(independent), x);
    for (const Mapping* mapping : mappings) mapping->apply(x);
  }
  Vector x(all);
  copy(system.x, x);
  for (const Mapping* mapping : mappings) mapping->apply(x);
  for (const Mapping* mapping : mappings) mapping->applyJ(d);
  std::vector<std::string> found;
  for (const Mapping* mapping : mappings) {
    const State& state = mapping->output();
    double error = 0, size = 0;
    for (Index i = 0; i < state.size(); ++i) {
      const Index row = state.firstRow() + i;
      if (state.kindOf(i) == RowKind::turn) continue;
      const Vec3 slope = (Vec3(ahead[row]) - Vec3(behind[row])) / (2 * h);
      error += (slope - Vec3(d[row])).squaredNorm(), size += slope.squaredNorm();
    }
    if (std::isfinite(size) && !(std::sqrt(error) <= 1e-3 * std::sqrt(size) + 1e-6))
      found.push_back(fmt::format("{}: {} ({}): its velocities are not the derivative of its positions: error {:.2g}",
                                  mapping->where().text(), mapping->path(), mapping->type(), std::sqrt(error / size)));
  }
  double work = 0;
  for (Index row = independent; row < all; ++row) work += f[row].dot(d[row]);
  for (auto mapping = mappings.rbegin(); mapping != mappings.rend(); ++mapping) (*mapping)->applyJT(f);
  double pulled = 0;
  for (Index row = 0; row < independent; ++row) pulled += f[row].dot(d[row]);
  if (!(std::abs(work - pulled) <= 1e-7 * (std::abs(work) + norm(f) * norm(d))))
    found.push_back(fmt::format("{}: the mappings below give forces back that do other work: {:.9g} for {:.9g}",
                                system.integrator().path(), pulled, work));
  return found;
}

}  // namespace

std::vector<std::string> brokenPromises(const Simulation& simulation, bool near_start, unsigned seed) {
  std::vector<std::string> all;
  for (const auto& system : simulation.systems()) {
    if (system->integrator().stateOwner()) continue;
    for (ForceField* field : system->forceFields())
      for (std::string& sentence : FieldCheck(*system, *field, ++seed)(near_start)) all.push_back(std::move(sentence));
    for (std::string& sentence : brokenMappings(*system, ++seed)) all.push_back(std::move(sentence));
  }
  return all;
}

}  // namespace stroma::stress
