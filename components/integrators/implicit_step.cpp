// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/implicit_step.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "components/integrators/solve_potential.h"

namespace stroma {
// ---- the step ----

StepReport ImplicitStep::solve(const ImplicitScheme& scheme, StopToken stop) {
  scheme_ = scheme;
  if (scheme.has_history) {
    // the way of the step before holds what relations to moved nodes made free ones do: along the constraint's forces
    system_->constraints().projectAcceleration(position_predictor);
    system_->constraints().projectAcceleration(velocity_predictor);
  }
  startBodies();
  energy_.stepBegins();
  const double whole = scheme.weight + scheme.old_weight;
  rule_ = {scheme.displacement + scheme.moved_after, whole, scheme.old_weight / whole, true, one_round};
  multipliers_.begin(rule_, !solvesOnce());
  if (!solvesOnce()) {
    turns_ = true, tangents_ = 0, keepTurning(false), endDefiniteDamping();
    StepReport report = !multipliers_.empty() ? solveConditions(stop) : iterates() ? solveIterating(stop) : solveAsNeeded(stop);
    if (endDefiniteDamping()) residual(system_->independent(right_side_));
    turnVelocities(stop, report);
    addTurning(false);
    bodies_.momenta(x(), v(), end_momenta_);
    return report;
  }
  StepReport report = solveLinearised(stop);
  if (report.diverged && std::ranges::any_of(system_->forceFields(), [](const ForceField* field) { return !field->traits().linear; }))
    report.reason += "; one linear solve takes a step of any length, newtonIterations=\"20\" shortens steps that go too far";
  if (!multipliers_.empty() && !report.failed()) multipliers_.correct(*solver_, tangent(), change_, {}, stop, report);
  turnVelocities(stop, report);
  bodies_.momenta(x(), v(), end_momenta_);
  return report;
}

void ImplicitStep::setTime(double time) {
  if (depends_on_time_) system_->setTime(time);
}

/// out += factor (rK K v - rM M v), K at the x of the last force.
void ImplicitStep::addDamping(double factor, Rows out) {
  const double r = factor * rayleigh_stiffness;
  if (has_rayleigh_stiffness_)
    system_->addStiffnessProduct(v(), {.stiffness = r, .rayleigh_stiffness = own_in_matrix ? 0 : factor, .part_of_damping = r}, out);
  addMassDamping(factor, out);
}

/// out -= factor rM M v.
void ImplicitStep::addMassDamping(double factor, Rows out) {
  if (own_in_matrix && rayleigh_mass != 0)
    system_->addMassProduct(v(), -factor * rayleigh_mass, out);
  else if (has_rayleigh_mass_ && !own_in_matrix)
    system_->addRayleighMassProduct(v(), rayleigh_mass, -factor, out);
}

void ImplicitStep::wholeForce(double time, Rows out, bool starts, double of_end) {
  setTime(time);
  limits_.wantStartForces(starts, of_end);
  system_->computeForce(system_->x, system_->v, system_->f);
  limits_.wantStartForces(false);
  copy(system_->independent(system_->f), out);
  addDamping(1, out);
}

SystemMatrix& ImplicitStep::tangent() {
  addTurning(turns_ && tangents_ > 0);
  if (tangents_++ == 0) keepTurning(true);
  return whole_.of(system_->matrix().withFactors(tangentFactors()));
}

MatrixFactors ImplicitStep::tangentFactors() const {
  const double w = scheme_.weight;
  MatrixFactors factors;
  factors.mass = 1 + w * rayleigh_mass;
  factors.stiffness = -w * (scheme_.displacement + rayleigh_stiffness);
  factors.damping = factors.rayleigh_stiffness = -w;
  factors.rayleigh_mass = w;
  factors.part_of_damping = -w * rayleigh_stiffness;
  return factors;
}

/// The equations linearised at (x0, v0), the unknown being u - v0. K then acts on p = drift v0 + position_predictor,
/// the way that the step makes when the velocity does not change, and on rK v0: together with the force, in one pass
/// over the elements.
StepReport ImplicitStep::solveLinearised(StopToken stop) {
  System& s = *system_;
  const Rows b = s.independent(right_side_), dv = change_;
  const bool two_times = depends_on_time_ && scheme_.old_weight != 0;
  if (two_times) wholeForce(scheme_.old_time, constant_, true, 0.5);
  setTime(scheme_.time);
  const double total = scheme_.weight + (two_times ? 0 : scheme_.old_weight);
  const double k = scheme_.weight * scheme_.drift / total + rayleigh_stiffness;
  if (!scheme_.has_history) {
    const MatrixFactors factors{.stiffness = k, .rayleigh_stiffness = own_in_matrix ? 0. : 1., .part_of_damping = rayleigh_stiffness};
    s.computeForceAndProduct(s.x, s.v, s.v, factors, right_side_);
  } else {
    copy(position_predictor, work_);
    scale(scheme_.weight / total, work_);
    axpy(k, v(), work_);
    s.computeForceAndProduct(s.x, s.v, work_, {.stiffness = 1}, right_side_);
    if (has_own_stiffness_damping_)
      s.addStiffnessProduct(v(), {.rayleigh_stiffness = own_in_matrix ? 0. : 1., .part_of_damping = rayleigh_stiffness}, b);
  }
  scale(total, b);
  addMassDamping(total, b);
  if (two_times) axpy(scheme_.old_weight, constant_, b);
  if (scheme_.has_history) {
    s.addMassProduct(velocity_predictor, 1, b);
    for (std::size_t i = 0; i < bodies_.count(); ++i)
      b[bodies_.row(i)] += momentum_predictor[i] - bodies_.times(i, x(), velocity_predictor[bodies_.row(i)]);
  }
  for (std::size_t i = 0; s.hasCurvedInertia() && i < bodies_.count(); ++i) b[bodies_.row(i)] -= turnedMomentum(i);
  s.constraints().project(b);
  projectFree(scheme_.old_time, scheme_.time, b);

  SystemMatrix& matrix = tangent();
  if (scheme_.from_predictor) {
    copy(velocity_predictor, work_);
    s.constraints().project(work_);
    matrix.multiply(work_, constant_);
    axpy(-1, constant_, b);
  }
  StepReport report;
  if (!solveOrShift(*solver_, matrix, b, dv, {.stop = stop}, report, {.result = &s})) return report;
  if (scheme_.from_predictor) axpy(1, work_, dv);
  s.constraints().project(dv);
  turnBodies();
  advance();
  return report;
}

/// u = v0 + dv and x = x0 + drift v0 + (displacement + moved_after) dv in one pass.
void ImplicitStep::advance() {
  const double drift = scheme_.drift, rest = scheme_.displacement + scheme_.moved_after - scheme_.drift;
  const double* __restrict change = change_.rows().data;
  double* __restrict velocity = v().data;
  double* __restrict position = x().data;
  const std::size_t count = x().doubles();
  orientations_.take(system_->motion(), x());
#pragma omp simd
  for (std::size_t i = 0; i < count; ++i) {
    velocity[i] += change[i];
    position[i] += drift * velocity[i] + rest * change[i];
  }
  if (scheme_.has_history) axpy(1, position_predictor, x());
  orientations_.turn(x());
}

/// A damping rK K v is a force, which must not change with K. With few iterations the scene asks for no more.
bool ImplicitStep::mayTryExact() const {
  constexpr int fewest = 5;
  return newton_.settings.iterations >= fewest && !has_rayleigh_stiffness_;
}

/// The exact tangent begins where a solve is slow, and where the iterations that are left are estimated to cost more than a few
/// with it.
bool ImplicitStep::beginFaster() {
  constexpr double usual_iterations = 4;
  const double before = costOfIteration(*system_), left = newton_.iterationsLeft();
  if (!exact_.beginForSpeed(*system_)) return false;
  const double most = left * before / costOfIteration(*system_);
  if (most < usual_iterations) {
    exact_.end();
    return false;
  }
  exact_.limitIterations(most);
  return true;
}

/// Newton's method; a solve that gets on by small factors goes on with the exact tangent where that costs less.
StepReport ImplicitStep::solveFromHere(StopToken stop) {
  newton_.settings.leaves_slow = mayTryExact() && exact_.mayBeFaster(*system_);
  StepReport report = newton_.solve(*this, *solver_, stop);
  newton_.settings.leaves_slow = false;
  if (report.failed() || report.newton_converged || !newton_.wasSlow()) return report;
  const auto goOn = [&] {
    const StepReport before = report;
    report = newton_.solve(*this, *solver_, stop);
    addCounts(before, report);
  };
  const bool is_exact = beginFaster();
  goOn();
  if (is_exact && !report.stopped && (report.diverged || !report.newton_converged)) {
    exact_.end(), exact_.noteSlow(), newton_.keepScale();
    goOn();
  }
  return report;
}

/// With a tangent that lacks a part of the derivative one solve leaves an error of h^2 in each step, a second one h^4.
StepReport ImplicitStep::solveAsNeeded(StopToken stop) {
  startIterating();
  const StepReport report = newton_.solve(*this, *solver_, stop);
  graph_.assign(newton_.history().begin(), newton_.history().end());
  takeChange();
  return report;
}

StepReport ImplicitStep::solveIterating(StopToken stop) {
  exact_.choose(*system_);
  const bool began_exact = exact_.isOn();
  startIterating();
  StepReport report = solveFromHere(stop);
  constexpr int most_unconverged = 25;
  for (int part = 0; part < most_unconverged && carries() && !report.failed(); ++part) {
    const StepReport before = report;
    report = solveFromHere(stop);
    addCounts(before, report);
  }
  const int of_last_solve = int(newton_.history().size()) - 1;  // a step can have several, each short enough
  if (began_exact && exact_.isTooDear(of_last_solve) && report.newton_converged && !report.failed()) {
    exact_.letGo();
    residual(system_->independent(right_side_));
  }
  if (exact_.isOn() && !report.stopped && !report.newton_converged) {  // it helped before, and does not here
    exact_.end();
    const StepReport before = report;
    report = newton_.solve(*this, *solver_, stop);
    addCounts(before, report);
  }
  if (!report.stopped && !report.newton_converged && mayTryExact() && exact_.begin(*system_)) {
    const StepReport before = report;
    report = newton_.solve(*this, *solver_, stop);
    addCounts(before, report);
  }
  if (!hasForces() && mayDivide(report)) report = solveInParts(report, stop);
  if (report.stopped) return report;
  if (lack_ > 0) {
    report.diverged = true;
    report.reason = fmt::format("nodes with a prescribed motion are stopped by something after {:.2g} of their way{}{}",
                                1 - lack_, report.reason.empty() ? "" : "; ", report.reason);
    return report;
  }
  const bool tried_exact = exact_.isOn();
  if (exact_.endStep(report.newton_converged && !report.diverged)) residual(system_->independent(right_side_));
  exact_tangent_steps_ += exact_.isOn() && !began_exact;
  if (tried_exact && !exact_.isOn() && !report.diverged) report.reason += "; with the exact tangent too";
  graph_.assign(newton_.history().begin(), newton_.history().end());
  if (settings_component_) settings_component_->noteResult(report, newton_);
  takeBack(report);
  takeChange();
  return report;
}

// ---- the step as equations for Newton's method ----

/// Starts from the positions before the step, where every energy is finite; directions that are held keep their
/// velocity. The first iteration is then the linearised step.
void ImplicitStep::startIterating() {
  copy(x(), x0_);
  copy(v(), v0_);
  has_constant_ = scheme_.old_weight != 0 || !multipliers_.empty();
  clear(constant_);
  if (scheme_.old_weight != 0) {
    wholeForce(scheme_.old_time, constant_, true, 0.5);
    scale(scheme_.old_weight, constant_);
  }
  if (!multipliers_.empty()) multipliers_.addCarried(constant_);
  setTime(scheme_.time);
  copy(v0_, work_);
  scale(scheme_.drift, work_);
  if (scheme_.has_history) axpy(1, position_predictor, work_);
  system_->constraints().project(work_);
  axpy(-1 / scheme_.displacement, work_, v());
  unknownsChanged();
  lack_ = 0, carries_ = 0, is_to_guess_ = !limits_.empty();
  if (limits_.empty()) return;
  // what has a prescribed motion goes as far as nothing is in its way, the rest of it after the next solve
  copy(x0_, carried_);
  system_->motion().difference(x(), carried_);
  if (largest(carried_) <= 4 * std::numeric_limits<double>::epsilon() * largest(x0_)) return;
  axpy(-1 / scheme_.displacement, carried_, v());
  unknownsChanged();
  lack_ = 1;
}

void ImplicitStep::place(RowRange rows) {
  const double old_part = scheme_.drift - scheme_.displacement, new_part = scheme_.displacement;
  const double* __restrict x0 = x0_.rows().data;
  const double* __restrict v0 = v0_.rows().data;
  const double* __restrict u = v().data;
  double* __restrict position = x().data;
  const std::size_t from = std::size_t(rows.first) * row_doubles, to = std::size_t(rows.end) * row_doubles;
  orientations_.take(system_->motion(), x0_.head(rows.end), rows.first);
#pragma omp simd
  for (std::size_t i = from; i < to; ++i) position[i] = x0[i] + old_part * v0[i] + new_part * u[i];
  if (scheme_.has_history) axpy(1, rows.of(ConstRows(position_predictor)), rows.of(x()));
  orientations_.turn(x().head(rows.end));
  orientations_.turn(x0_.head(rows.end));
}

/// R = weight F(x(u), u) + old_weight F(x0, v0) - M (u - v0 - velocity_predictor), M that of x(u), or the mean of both where both
/// forces count. The stiffness of rK K u is the one
/// at x(u): with that of x0 a method of second order would be of first. Its derivative is left out of the tangent,
/// which costs iterations, not accuracy: hardly any, where the rest of the tangent is exact (chooseTurning()).
void ImplicitStep::residual(Rows out) {
  System& s = *system_;
  addTurning(false);
  s.computeForce(s.x, s.v, s.f);
  copy(s.independent(s.f), out);
  addDamping(1, out);
  scale(scheme_.weight, out);
  if (has_constant_) axpy(1, constant_, out);
  copy(v(), work_);
  axpy(-1, v0_, work_);
  if (scheme_.has_history) axpy(-1, velocity_predictor, work_);
  s.addMassProduct(work_, -1, out);
  if (scheme_.old_weight != 0 && s.hasCurvedInertia()) addMassWhereTheStepStarts(out);
  // of a turning body the change of momentum J(x(u)) u - L0 instead of J(x(u)) (u - v0)
  for (std::size_t b = 0; b < bodies_.count(); ++b) {
    const Index row = bodies_.row(b);
    Vec3 start = v0_[row];
    if (scheme_.has_history) start += velocity_predictor[row];
    out[row] += start_momenta_[b] + momentum_predictor[b] - bodies_.times(b, x(), start);
  }
  s.constraints().project(out);
  light_.narrow(out);
}

/// The incremental potential, whose gradient is -R:
///   weight/displacement U(x(u)) + 1/2 |u - v0 - velocity_predictor|^2_M + weight/2 (rM |u|^2_M - rK u K u) -
/// old_weight F(x0, v0).u with the K of the last residual(), which stays what it is while a line search asks for
/// energies only.
double ImplicitStep::energy() {
  System& s = *system_;
  double sum = scheme_.weight / scheme_.displacement * (s.potentialEnergy(s.x) + (lends_energy_ ? solvePotential(s) : 0));
  if (has_constant_) sum -= dot(constant_, v());
  if (has_rayleigh_mass_ || has_rayleigh_stiffness_) {
    addTurning(false);
    clear(work_);
    addDamping(1, work_);
    sum -= 0.5 * scheme_.weight * dot(work_, v());
  }
  copy(v(), work_);
  axpy(-1, v0_, work_);
  if (scheme_.has_history) axpy(-1, velocity_predictor, work_);
  const Rows momentum = s.independent(right_side_);
  clear(momentum);
  s.addMassProduct(work_, 0.5, momentum);
  return sum + dot(work_, momentum);
}

double ImplicitStep::loadScale() const { return scheme_.weight * measure_.force(system_->f); }

/// Energies are those of the incremental potential: forces are weighed with the step.
RoundOff ImplicitStep::roundOff() {
  const RoundOff of_forces = positionRoundOff(*system_, measure_, work_, change_);
  return {scheme_.weight * of_forces.residual, scheme_.weight / scheme_.displacement * of_forces.energy};
}

double ImplicitStep::travelled() const {
  if (!system_->motion().turns()) return distance(x(), x0_);
  Vector way(x0_.count());
  copy(x0_, way);
  system_->motion().difference(x(), way);
  return measure_.way(way);
}

std::string ImplicitStep::describe() const {
  if (solvesOnce()) return ", linearised once: 1 force evaluation with its product, 1 linear solve";
  if (!iterates())
    return fmt::format(", {} linear solves: with one the rule {} gain energy, because {}", enough_solves_,
                       keeps_order_ ? "might, at large steps," : "would be of first order and might", approximation_);
  const double forcing = newton_.settings.forcing;
  return fmt::format(", up to {} Newton iterations{} to a relative residual of {:g}, line search on {}{}", newton_.settings.iterations,
                     limiter_.empty() ? "" : fmt::format(" (chosen because {} limits how far bodies move)", limiter_),
                     newton_.settings.relative_residual,
                     newton_.settings.use_energy ? "the incremental potential" : "the work of the residual",
                     forcing > 0 ? fmt::format("; early linear solves to {:g}", forcing) : "");
}

}  // namespace stroma
