// SPDX-License-Identifier: LGPL-2.1-or-later
// StaticSolver: the equilibrium f(x) = 0 under the loads of each step, by Newton's method.
//
//   -K(x) dx = f(x),   x += s dx,   K = df/dx
//
// with the free directions of the constraints only. s comes from a line search: Armijo backtracking on the potential
// energy when every force has one, else the norm of the residual must fall. Masses matter through gravity alone;
// velocities are zero after a step. A tangent that is not positive definite (buckling, an inverted element) gets a
// multiple of its own diagonal until it can be solved; the report says so.
//
// A step ends when |f| <= relative_residual_tolerance_threshold * the |f| where the step starts (reactions of held
// nodes included), or when one of the other thresholds (off by default: they are absolute, or measure the step instead
// of the balance of forces) is met, or when dx no longer changes x in double precision. After newton_iterations without
// that, the step says that it has not converged and the state is the last iterate. SOFA's defaults are 1 iteration and
// 1e-5 for all four.
//
// A body that is not held and whose loads do not cancel has no equilibrium: the step then ends with a sentence naming
// the body and the direction.
//
// Example:
// <Node name="root" dt="1" gravity="0 -9.81 0">
//   <StaticSolver newton_iterations="20"/>
//   <SparseLDLSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/>
//   <UniformMass totalMass="1"/>
//   <TetrahedronFEMForceField youngModulus="5000" poissonRatio="0.3" method="small"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "framework/scene/factory.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/newton.h"
#include "framework/simulation/system.h"

namespace stroma {
namespace {

/// f(x) = 0 with the iterate in System::x.
class Equilibrium final : public NonlinearProblem {
 public:
  void compile(System& system) {
    system_ = &system;
    base_.resize(system.independentRows());
    start_.resize(system.independentRows());
  }
  void begin() { copy(rows(), start_); }
  void residual(Rows out) override {
    system_->computeForce(system_->x, system_->v, system_->f);
    copy(ConstRows{system_->f.rows().data, out.count}, out);
    system_->project(out);
  }
  SystemMatrix& tangent() override { return system_->matrix({.stiffness = -1}); }
  double energy() override { return system_->potentialEnergy(system_->x); }
  double loadScale() const override { return std::sqrt(dot(system_->f, system_->f)); }
  void keep() override { copy(rows(), base_); }
  void move(double step, ConstRows direction) override {
    copy(base_, rows());
    axpy(step, direction, rows());
  }
  double displacementPerUnknown() const override { return 1; }
  ConstRows positions() const override { return rows(); }
  double travelled() const override {
    double sum = 0;
    for (Index i = 0; i < base_.count(); ++i) sum += (system_->x[i] - start_[i]).squaredNorm();
    return std::sqrt(sum);
  }

 private:
  Rows rows() const { return {system_->x.rows().data, system_->independentRows()}; }
  System* system_ = nullptr;
  Vector base_, start_;
};

class StaticSolver final : public Integrator {
 public:
  void declare(DataTable& table) override;
  void compile(System& system) override;
  StepReport step(System& system, const StepContext& context) override;
  std::string describe() const override;
  void reset() override { checked_projectors_ = std::size_t(-1); }

 private:
  std::string freeBody(System& system);

  NewtonSettings settings_;
  std::vector<double> graph_;
  Link<LinearSolver> solver_link_{"linear solver"};
  LinearSolver* solver_ = nullptr;
  Equilibrium problem_;
  Newton newton_;
  Vector force_, mode_, product_[3];
  std::vector<double> blocks_;
  std::size_t checked_projectors_ = std::size_t(-1);  ///< how many projectors were active at the last check
};

void StaticSolver::declare(DataTable& table) {
  table.add("newton_iterations", settings_.iterations)
      .help("largest number of Newton iterations a step")
      .unit("-")
      .min(1);
  table.add("relative_residual_tolerance_threshold", settings_.relative_residual)
      .help("converged when |f| is below this times the |f| where the step starts, reactions included")
      .unit("-")
      .min(0);
  table.add("absolute_residual_tolerance_threshold", settings_.absolute_residual)
      .help("converged when |f| is below this; 0: not used")
      .unit("N")
      .min(0);
  table.add("relative_correction_tolerance_threshold", settings_.relative_correction)
      .help("converged when |dx| is below this times the displacement of the step; 0: not used")
      .unit("-")
      .min(0);
  table.add("absolute_correction_tolerance_threshold", settings_.absolute_correction)
      .help("converged when |dx| is below this; 0: not used")
      .unit("m")
      .min(0);
  table.add("should_diverge_when_residual_is_growing", settings_.stop_when_residual_grows)
      .help("end the run when an iteration makes the residual larger");
  table.add("residualGraph", graph_).help("|f| of the last step's Newton iterations").unit("N").output();
  table.addLink("linearSolver", solver_link_).help("the linear solver; without it, the one of the same node");
}

void StaticSolver::compile(System& system) {
  system.refuseRayleighFactors("statics");
  solver_ = system.linearSolver();
  if (!solver_)
    throw ComponentError("statics needs a linear solver, and " + node().path() + " has none",
                         "a linear solver in the same node", "add <SparseLDLSolver/>");
  settings_.use_energy = system.isConservative();
  newton_.settings = settings_;
  newton_.compile(system.independentRows());
  problem_.compile(system);
  force_.resize(system.independentRows());
  mode_.resize(system.independentRows());
  for (Vector& product : product_) product.resize(system.independentRows());
  graph_.reserve(std::size_t(settings_.iterations) + 2);
}

StepReport StaticSolver::step(System& system, const StepContext& context) {
  system.beginStep(context);
  clear(system.v);
  StepReport report;
  if (checked_projectors_ != system.projectors().size()) {
    checked_projectors_ = system.projectors().size();
    report.reason = freeBody(system);
    report.diverged = !report.reason.empty();
    if (report.diverged) return report;
  }
  problem_.begin();
  report = newton_.solve(problem_, *solver_);
  graph_.assign(newton_.history().begin(), newton_.history().end());
  system.applyMappings();
  return report;
}

/// A sentence when some body can be shifted as a whole without any force resisting while its loads push it that way.
/// The stiffness felt by the three translations of a body is T^T A T, T its three columns.
std::string StaticSolver::freeBody(System& system) {
  problem_.residual(force_);
  SystemMatrix& matrix = problem_.tangent();
  matrix.diagonalBlocks(blocks_);
  for (const State* state : system.states()) {
    if (state->firstRow() >= system.independentRows()) continue;
    const Index first = state->firstRow(), last = first + state->size();
    Mat3 stiffness = Mat3::Zero();
    Vec3 load = Vec3::Zero();
    double diagonal = 0, loads = 0;
    for (Index i = first; i < last; ++i) {
      load += force_[i];
      loads += force_[i].norm();
      for (int c = 0; c < 3; ++c) diagonal += std::abs(blocks_[9 * std::size_t(i) + 4 * std::size_t(c)]);
    }
    for (int c = 0; c < 3; ++c) {
      clear(mode_);
      for (Index i = first; i < last; ++i) mode_[i][c] = 1;
      Vec3 held = Vec3::Zero();
      system.project(mode_);
      for (Index i = first; i < last; ++i) held += Vec3::Unit(c) - mode_[i];
      matrix.multiply(mode_, product_[c]);
      for (Index i = first; i < last; ++i) stiffness.col(c) += product_[c][i];
      // directions that constraints hold resist with what a row resists
      stiffness.col(c) += held * (diagonal / double(3 * state->size()));
    }
    const Eigen::SelfAdjointEigenSolver<Mat3> modes(0.5 * (stiffness + stiffness.transpose()));
    for (int m = 0; m < 3; ++m) {
      const Vec3 direction = modes.eigenvectors().col(m);
      if (std::abs(modes.eigenvalues()[m]) > 1e-11 * diagonal || std::abs(direction.dot(load)) <= 1e-9 * loads)
        continue;
      return fmt::format(
          "{} is not held in the direction ({:.3g} {:.3g} {:.3g}) and the forces on it there sum to {:.3g} N: "
          "it has no equilibrium. Hold some of its nodes (FixedProjectiveConstraint)",
          state->path(), direction[0], direction[1], direction[2], direction.dot(load));
    }
  }
  return {};
}

std::string StaticSolver::describe() const {
  return fmt::format("static equilibrium: up to {} Newton iterations to a relative residual of {:g}, line search on {}",
                     settings_.iterations, settings_.relative_residual,
                     settings_.use_energy ? "the potential energy" : "the work of the residual");
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(static_solver) {
  factory.add<stroma::StaticSolver>("StaticSolver", "static equilibrium by Newton's method with line search");
}
