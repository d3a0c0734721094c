// SPDX-License-Identifier: LGPL-2.1-or-later
// CondensedDynamicSolver: the motion of a linear body with one constant matrix, inverted beforehand (Bro-Nielsen and
// Cotin 1996: CD; with condensed="false" FD).
//
// Lumped masses m_i, damping alpha m_i, and the paper's finite differences of u at times t - dt, t and t + dt:
//
//   (M/dt^2 + D/2dt + K) u(t+dt) = f(t+dt) + M (2 u(t) - u(t-dt))/dt^2 + D u(t-dt)/2dt,   D = alpha M
//
// alpha is rayleighMass, the masses' own added to it. u(t-dt) = u(t) - dt v(t), v(t+dt) = (u(t+dt) - u(t))/dt: velocities are
// those of the middle of steps. interiorMass is the treatment of the interior mass:
//
// - "exact": A = M/dt^2 + D/2dt + K is condensed with all of M, A*_ss = A_ss - A_si A_ii^-1 A_is, and r its right side,
//   r*_s = r_s - A_si A_ii^-1 r_i. The motion is that of the whole body; because the right side contains the last motion of
//   the interior, each step makes a forward and a backward sweep with the factor of A_ii, u_i = A_ii^-1 (r_i - A_is u_s).
// - "neglected", as the paper has it: only the kept nodes (the surface) have inertia,
//
//     (M_ss/dt^2 + D_ss/2dt + K*_ss) u_s(t+dt) = f*_s + ...,   K*_ss = K_ss - K_si K_ii^-1 K_is
//
//   the cost of a step is independent of the interior, which follows, u_i = K_ii^-1 (f_i - K_is u_s), on demand.
// - "shared": the same, with the mass inside given to the kept nodes that carry it (Guyan's reduction T^T M T,
//   T = -K_ii^-1 K_is, lumped by sums of rows; where one is below zero it is left out, and the others carry it).
//
// The last two are different bodies from the whole one: for a cube of 8^3 cells with half of its free nodes inside, the motion
// after a sudden load differs by 4 to 14 % of the largest displacement with "shared" and by 17 to 83 % with "neglected", most
// for sudden loads and short steps.
//
// Stable at every time step where K resists every motion: with a = alpha dt/2 and w an angular frequency of the body, both
// roots of (1 + a + (w dt)^2) z^2 - 2 z + (1 - a) = 0 lie within the unit circle. An undamped oscillation is multiplied by
// 1/sqrt(1 + (w dt)^2) in each step, so that the method damps fast ones: with n steps per period, a fraction of about (2
// pi)^2/2n is lost in each period. explain prints the loss of the slowest motion. Overdamped motions creep back without
// oscillating, so that damping can make a motion last longer. For alpha dt > 2 one root is negative, and part of the velocity
// changes its sign in every step: a warning is printed. If K is unstable in some direction, this motion grows with any step: a
// warning is printed too.
//
// One half of the symmetric inverse of the kept nodes is stored and multiplied in one pass. With condensed="false" the sparse
// factor can replace it: both are timed during the precomputation (on the machine and with the threads of that run), the
// faster one is used, and explain prints the times. The factor is faster from about 200 nodes on. The two differ by round-off:
// runs of a body near that size are bitwise reproducible only with solve="inverse" or "factor", or with a file of cacheFolder,
// which stores the choice.
//
// A node moved by a constraint is an unknown load: see CondensedStaticSolver, also for Lagrangian constraints and barriers.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <CondensedDynamicSolver rayleighMass="2"/>
//   <RegularGridTopology n="3 3 5" min="0 0 0" max="0.1 0.1 0.2"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="1"/>
//   <HexahedronFEMForceField youngModulus="50000" poissonRatio="0.4" method="small"/>
//   <FixedProjectiveConstraint indices="0 1 2 3 4 5 6 7 8"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>

#include "components/condensation/condensed_integrator.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class CondensedDynamicSolver final : public CondensedIntegrator {
 public:
  void declare(DataTable& table) override {
    CondensedIntegrator::declare(table);
    table.add("rayleighMass", rayleigh_mass_).help("alpha: damping proportional to the mass").unit("1/s").min(0);
    table.addChoice("interiorMass", interior_mass_, {"exact", "shared", "neglected"})
        .help(
            "treatment of the mass of inside nodes: kept exactly, at the cost of a sweep through the inside per step; moved to the "
            "kept nodes; left out");
    table.addChoice("solve", solve_, {"auto", "inverse", "factor"})
        .help("with condensed=\"false\": by the inverse, by the sparse factor, or by the faster, measured");
  }
  StepReport step(System& system, const StepContext& context) override;

 protected:
  bool isDynamic() const override { return true; }
  double rayleighMass() const override { return rayleigh_mass_; }
  bool keepsInteriorMass() const override { return condensed_ && interior_mass_ == InteriorMass::exact; }
  bool sharesInteriorMass() const override { return condensed_ && interior_mass_ == InteriorMass::shared; }
  Form form() const override {
    if (condensed_) return interior_mass_ == InteriorMass::exact ? Form::joined : Form::symmetric;
    return solve_ == Solve::inverse ? Form::symmetric : Form::factor;
  }
  bool mayInvert() const override { return !condensed_ && solve_ == Solve::automatic; }
  std::function<void()> trialProduct(std::size_t rows) const override;
  std::unique_ptr<PartialCholesky> makeFactor() const override { return makePartialCholesky(); }
  void checkChoices() const override;
  void prepare(System& system) override;
  std::string stepText() const override;
  void complianceOf(const Touch& touch, double* column) override;
  Mat3 complianceBlock(Index i, Index j) override;
  void addResponse(const std::vector<Index>& nodes, const std::vector<std::array<double, 3>>& forces,
                   double* u) override;
  void forward(double* y) override { eliminated_.forward(y, sweep_work_.data()); }
  void backward(double* y) override { eliminated_.backward(y, sweep_work_.data()); }

 private:
  enum class InteriorMass : int { exact, shared, neglected };
  enum class Solve : int { automatic, inverse, factor };
  void multiply(const double* r, double* u);
  void multiplyKept(const double* r, double* u);
  void multiplyHalf(const void* inverse, std::size_t rows, const double* r, double* u, double* work) const;
  /// Of the inverse that is stored.
  std::size_t keptUnknowns() const {
    return 3 * std::size_t(body_.free() - (used_form_ == Form::joined ? body_.interior() : firstActive()));
  }
  std::array<double, 2> slowestMotion();
  void findSlowest();
  /// 1/dt^2 + alpha/2dt of a node
  double perMass(std::size_t node) const {
    return 1 / (timeStep() * timeStep()) + massDamping()[node] / (2 * timeStep());
  }
  void gatherState(const System& system);
  void formRightSide();
  void addTimedForces();
  StepReport giveUp(System& system, const std::string& reason, bool is_stopped = false);

  double rayleigh_mass_ = 0;
  InteriorMass interior_mass_ = InteriorMass::exact;
  Solve solve_ = Solve::automatic;

  Array<double> u_, v_, next_, right_, reduced_, work_;  ///< shape (padded); work_ once for each piece
  std::map<Index, Array<double>> columns_;               ///< of C, three of each node that asked for; shape (3, padded)
  Array<double> push_;                                   ///< forces of constraint, and what they lead to
  Array<double> kept_;                                   ///< load and displacement of the kept nodes between sweeps
  double slowest_ = 0;                                   ///< angular frequency [rad/s], of a few iterations
  Array<double> of_u_, of_v_;                            ///< right side per u and per v, shape (padded)
};

void CondensedDynamicSolver::checkChoices() const {
  if (condensed_ && solve_ == Solve::factor)
    throw ComponentError(
        "solve=\"factor\" is of the whole matrix, and condensed=\"true\" takes the inverse of the kept nodes",
        "one of the two", "condensed=\"false\"");
  if (!condensed_ && data().find("interiorMass")->isSet())
    throw ComponentError("interiorMass is given, and condensed=\"false\" keeps every node with its mass",
                         "one of the two");
  if (solve_ == Solve::factor && isSingle())
    throw ComponentError(
        "precision=\"single\" is of the inverse, and solve=\"factor\" takes the sparse factor, which is "
        "in double precision",
        "one of the two", "solve=\"inverse\"");
}

void CondensedDynamicSolver::prepare(System&) {
  for (Array<double>* vector : {&u_, &v_, &next_, &right_, &of_u_, &of_v_}) vector->assign(padded(), 0.0);
  if (!body_.timedNodes().empty()) reduced_.assign(padded(), 0.0);
  columns_.clear();
  const double dt = timeStep();
  // M (u + dt v)/dt^2 + D (u - dt v)/2dt
  for (std::size_t i = 0; i < 3 * std::size_t(active()); ++i) {
    const double m = inertia()[i], d = m * massDamping()[i / 3];
    of_u_[i] = m / (dt * dt) + d / (2 * dt);
    of_v_[i] = m / dt - d / 2;
  }
  if (used_form_ != Form::factor) {
    work_.assign(SymmetricPanels<double>{nullptr, keptUnknowns()}.pieces() * padded(), 0.0);
    kept_.assign(used_form_ == Form::joined ? 2 * chunksOf(keptUnknowns()) * lanes : 0, 0.0);
  }
  const double alpha = massDamping().empty() ? 0 : *std::max_element(massDamping().begin(), massDamping().end());
  if (alpha * dt > 2)
    warn(fmt::format("damping by the mass of {:g} 1/s times dt = {:g} s is {:.3g}, above 2: velocities change their "
                     "sign from step to step",
                     alpha, dt, alpha * dt),
         fmt::format("dt below {:.2g} s, or less rayleighMass", 2 / alpha));
  findSlowest();
}

// With c = 1/dt^2 + alpha/2dt of each node, (c M + K)^-1 c M has the largest eigenvalue q, by power iteration, in the
// slowest motion y: y K y = (1/q - 1) y c M y, and K is negative where it is above one. Quotients are never above it.
// Returns q and w^2 = y K y / y M y.
std::array<double, 2> CondensedDynamicSolver::slowestMotion() {
  constexpr int iterations = 10;
  const std::size_t count = 3 * std::size_t(active());
  double quotient = 1, square = 0;
  for (std::size_t i = 0; i < count; ++i) next_[i] = 1 + 0.5 * std::sin(double(i));
  for (int k = 0; k < iterations; ++k) {
    double before = 0, after = 0, mass = 0;
    for (std::size_t i = 0; i < count; ++i) {
      right_[i] = inertia()[i] * perMass(i / 3) * next_[i];
      before += right_[i] * next_[i];
      mass += inertia()[i] * next_[i] * next_[i];
    }
    if (!(before > 0)) break;
    multiply(right_.data(), next_.data());
    for (std::size_t i = 0; i < count; ++i) after += right_[i] * next_[i];
    quotient = after / before;
    square = before / mass * (1 / quotient - 1);
  }
  std::fill(next_.begin(), next_.end(), 0.0);
  std::fill(right_.begin(), right_.end(), 0.0);
  return {quotient, square};
}

void CondensedDynamicSolver::findSlowest() {
  if (base_.size() != 2) {
    const std::array<double, 2> found = slowestMotion();
    base_.assign(found.begin(), found.end());
  }
  const double square = base_[1];
  slowest_ = std::sqrt(std::max(square, 0.0));
  if (base_[0] > 1 + 1e-9)
    warn(
        fmt::format("the stiffness pushes in some direction: a motion grows by a factor of {:.3g} or more in each step",
                    1 / (1 - std::sqrt(-square) * timeStep())),
        "force fields that resist every motion");
}

std::string CondensedDynamicSolver::stepText() const {
  const double angle = slowest_ * timeStep(), pi = std::acos(-1.0);
  return fmt::format(
      "{} dynamic: {} of {} nodes{}; stable at every time step; of the slowest motion, below {:.3g} Hz, the method "
      "takes "
      "{:.2g} % a period",
      condensed_ ? "condensed" : "full",
      used_form_ == Form::factor   ? "a sweep forth and back through the sparse factor"
      : used_form_ == Form::joined ? fmt::format("one product with half of the inverse between sweeps through the "
                                                 "factor of {} nodes inside, which interiorMass=\"shared\" or "
                                                 "\"neglected\" would save; condensed=\"false\" mostly costs less",
                                                 body_.interior())
                                   : "one product with half of the inverse",
      active(), isSingle() && used_form_ != Form::factor ? " in single precision" : "", slowest_ / (2 * pi),
      angle > 0 ? 100 * (1 - std::pow(1 + angle * angle, -pi / angle)) : 0.0);
}

void CondensedDynamicSolver::multiply(const double* r, double* u) {
  if (used_form_ == Form::symmetric) return multiplyKept(r, u);
  std::copy(r, r + 3 * active(), u);
  forward(u);
  if (used_form_ == Form::joined) {
    double *load = kept_.data(), *result = load + kept_.size() / 2, *own = u + 3 * body_.interior();
    std::copy(own, own + keptUnknowns(), load);
    multiplyKept(load, result);
    std::copy(result, result + keptUnknowns(), own);
  }
  backward(u);
}

void CondensedDynamicSolver::multiplyKept(const double* r, double* u) {
  multiplyHalf(compliance(), keptUnknowns(), r, u, work_.data());
}

void CondensedDynamicSolver::multiplyHalf(const void* inverse, std::size_t rows, const double* r, double* u,
                                          double* work) const {
  if (isSingle()) {
    SymmetricPanels<float>{static_cast<const float*>(inverse), rows}.multiply(r, u, work);
  } else {
    SymmetricPanels<double>{static_cast<const double*>(inverse), rows}.multiply(r, u, work);
  }
}

std::function<void()> CondensedDynamicSolver::trialProduct(std::size_t rows) const {
  const std::size_t bytes = SymmetricPanels<double>::size(rows) * (isSingle() ? 4 : 8);
  const std::size_t length = chunksOf(rows) * lanes, pieces = SymmetricPanels<double>{nullptr, rows}.pieces();
  const auto inverse = std::make_shared<Array<double>>(bytes / sizeof(double) + 1, 0.0);
  const auto vectors = std::make_shared<Array<double>>((2 + pieces) * length, 1.0);
  return [this, rows, length, inverse, vectors] {
    double* r = vectors->data();
    multiplyHalf(inverse->data(), rows, r, r + length, r + 2 * length);
  };
}

void CondensedDynamicSolver::complianceOf(const Touch& touch, double* column) {
  Array<double> load(padded(), 0.0), result(padded(), 0.0);
  for (Index c = 0; c < 3; ++c) load[std::size_t(3 * touch.node + c)] = touch.direction[c];
  multiply(load.data(), result.data());
  std::copy(result.begin(), result.end(), column);
}

/// An entry of the stored inverse, or of columns that are computed once for each node that asks.
Mat3 CondensedDynamicSolver::complianceBlock(Index i, Index j) {
  Mat3 block;
  const Index first = used_form_ == Form::joined ? body_.interior() : 0;
  if (used_form_ != Form::factor && i >= first && j >= first) {
    const auto read = [&](const auto& panels) {
      for (Index a = 0; a < 3; ++a)
        for (Index b = 0; b < 3; ++b)
          block(a, b) = panels.at(std::size_t(3 * (i - first) + a), std::size_t(3 * (j - first) + b));
    };
    if (isSingle())
      read(SymmetricPanels<float>{static_cast<const float*>(compliance()), keptUnknowns()});
    else
      read(SymmetricPanels<double>{static_cast<const double*>(compliance()), keptUnknowns()});
    return block;
  }
  Array<double>& columns = columns_[j];
  for (Index b = 0; columns.size() < 3 * padded(); ++b) {
    columns.resize(std::size_t(b + 1) * padded());
    complianceOf({j, Vec3::Unit(b)}, columns.data() + std::size_t(b) * padded());
  }
  for (Index b = 0; b < 3; ++b)
    block.col(b) = Eigen::Map<const Vec3>(columns.data() + std::size_t(b) * padded() + std::size_t(3 * i));
  return block;
}

void CondensedDynamicSolver::addResponse(const std::vector<Index>& nodes,
                                         const std::vector<std::array<double, 3>>& forces, double* u) {
  push_.assign(2 * padded(), 0.0);
  for (std::size_t k = 0; k < nodes.size(); ++k)
    for (std::size_t c = 0; c < 3; ++c) push_[3 * std::size_t(nodes[k]) + c] = forces[k][c];
  double* answer = push_.data() + padded();
  multiply(push_.data(), answer);
  for (std::size_t i = 0; i < 3 * std::size_t(active()); ++i) u[i] += answer[i];
}

void CondensedDynamicSolver::gatherState(const System& system) {
  const double *x = system.x.rows().data, *v = system.v.rows().data;
  for (Index node = 0; node < active(); ++node)
    for (int c = 0; c < 3; ++c) {
      const std::size_t at = std::size_t(activeRow(node)) * row_doubles + std::size_t(c), i = std::size_t(3 * node + c);
      u_[i] = x[at] - origin()[i];
      v_[i] = v[at];
    }
}

void CondensedDynamicSolver::formRightSide() {
  const double* __restrict f = constantForce().data();
#pragma omp simd
  for (std::size_t i = 0; i < right_.size(); ++i) right_[i] = f[i] + of_u_[i] * u_[i] + of_v_[i] * v_[i];
}

void CondensedDynamicSolver::addTimedForces() {
  if (body_.timedNodes().empty()) return;
  body_.updateTimedForces();
  if (reduceTimedInterior(reduced_.data()))
    for (std::size_t i = 0; i < right_.size(); ++i) right_[i] += reduced_[i];
  for (const Index node : body_.timedNodes())
    if (node >= firstActive()) Eigen::Map<Vec3>(right_.data() + 3 * (node - firstActive())) += body_.timedForce(node);
}

StepReport CondensedDynamicSolver::giveUp(System& system, const std::string& reason, bool is_stopped) {
  restoreTouched(system);
  for (Index node = 0; node < active(); ++node) system.v[activeRow(node)] = Eigen::Map<Vec3>(v_.data() + 3 * node);
  StepReport report = failure(reason);
  report.diverged = !is_stopped, report.stopped = is_stopped;
  return report;
}

StepReport CondensedDynamicSolver::step(System& system, const StepContext& context) {
  if (context.dt != timeStep())
    return failure(fmt::format("the matrix was made for dt = {:g} s, and the step has {:g} s", timeStep(), context.dt));
  gatherState(system);
  formRightSide();
  body_.projectNodes(firstActive(), right_.data());
  moveTouched(system, context);
  if (!touchFault().empty()) return giveUp(system, touchFault(), context.stop.isStopAsked());
  addTimedForces();
  for (const Hand& hand : hands()) Eigen::Map<Vec3>(right_.data() + 3 * hand.node) += hand.force;
  multiply(right_.data(), next_.data());
  if (!touches().empty()) {
    const Eigen::VectorXd& reaction = solveTouches(next_.data());
    Eigen::Map<Eigen::VectorXd>(next_.data(), Index(next_.size())).noalias() += touchColumns() * reaction;
  }
  StepReport report;
  if (!holdConditions(system, next_, context.stop, report) || !holdContact(system, next_, context.stop, report))
    return giveUp(system, report.reason, report.stopped);
  for (std::size_t i = 0; i < v_.size(); ++i) right_[i] = (next_[i] - u_[i]) / context.dt;
  if (!writeActive(system, next_.data(), right_.data()))
    return giveUp(system, "a load is not finite, or the body has left the range of numbers");
  finish(system);
  others().addTo(report);
  return report;
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(condensed_dynamic_solver) {
  factory.add<stroma::CondensedDynamicSolver>("CondensedDynamicSolver",
                                              "linear dynamics by a constant matrix inverted beforehand");
}
