// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/explicit_step.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "components/integrators/explicit_parts.h"
#include "components/integrators/newton.h"
#include "components/integrators/stable_step.h"
#include "framework/mechanics/frames.h"
#include "framework/simulation/system_report.h"

namespace stroma {

// ---- accelerations ----

void Acceleration::compile(System& system, const std::string& method) {
  system_ = &system;
  bodies_.compile(system);
  force_.resize(bodies_.empty() ? 0 : system.independentRows());
  solver_ = nullptr;
  if (system.actors().massIsDiagonal()) {
    inverse_mass_ = &system.constraints().inverseLumpedMass();
    return;
  }
  system.constraints().requireMass();
  solver_ = system.linearSolver();
  if (!solver_)
    throw ComponentError(fmt::format("the mass is not diagonal, so {} needs a linear solver, and {} has none", method,
                                     system.node().path()),
                         "a linear solver in the same node, or a diagonal mass",
                         "use DiagonalMass, or add <CGLinearSolver iterations=\"25\" tolerance=\"1e-9\"/>");
  right_side_.resize(system.independentRows());
}

bool Acceleration::solve(ConstRows x, ConstRows v, ConstRows f, Rows a, StopToken stop, StepReport& report) {
  if (bodies_.empty()) return solveForMomenta(x, f, a, stop, report);
  copy(f, force_);
  bodies_.addGyroscopic(x, v, -1, force_);
  return solveForMomenta(x, force_, a, stop, report);
}

bool Acceleration::solveForMomenta(ConstRows x, ConstRows f, Rows a, StopToken stop, StepReport& report) {
  if (solver_) {
    copy(f, right_side_);
    system_->constraints().project(right_side_);
    SystemMatrix& matrix = system_->matrix().withFactors({.mass = 1});
    if (!solveOrShift(*solver_, matrix, right_side_, a, {.stop = stop}, report, {.result = system_})) return false;
  } else {
    const double* __restrict force = f.data;
    const double* __restrict inverse = inverse_mass_->data();
    double* __restrict out = a.data;
    for (Index i = 0; i < a.count; ++i)
      for (int l = 0; l < row_doubles; ++l) out[row_doubles * i + l] = force[row_doubles * i + l] * inverse[i];
    bodies_.divide(x, f, a);
    system_->constraints().projectAcceleration(a);
    return true;
  }
  system_->constraints().project(a);
  return true;
}

std::string Acceleration::describe() const {
  return solver_ ? "a linear solve with the mass for each" : "the mass inverted once";
}

// ---- schemes ----

ExplicitScheme fromRungeKutta(std::string name, const std::vector<std::vector<double>>& a,
                              const std::vector<double>& b) {
  ExplicitScheme scheme;
  scheme.name = std::move(name);
  const std::size_t stages = a.size();
  // (row A)_j for a row of coefficients of earlier stages
  const auto timesA = [&a](const std::vector<double>& row) {
    std::vector<double> product(row.size(), 0);
    for (std::size_t k = 0; k < row.size(); ++k)
      for (std::size_t j = 0; j < a[k].size(); ++j) product[j] += row[k] * a[k][j];
    return product;
  };
  for (std::size_t i = 0; i < stages; ++i) {
    double time = 0;
    for (double value : a[i]) time += value;
    scheme.stages.push_back({time, timesA(a[i]), a[i]});
  }
  scheme.x = timesA(b);
  scheme.v = b;
  return scheme;
}

namespace {

/// One step of h = 1 of x'' = -square x from (x, v), in place.
void stepOscillator(const ExplicitScheme& scheme, double square, double& x, double& v) {
  std::vector<double> a;
  const auto sum = [&a](const std::vector<double>& weights) {
    double total = 0;
    for (std::size_t j = 0; j < weights.size(); ++j) total += weights[j] * a[j];
    return total;
  };
  for (const ExplicitScheme::Stage& stage : scheme.stages) a.push_back(-square * (x + stage.time * v + sum(stage.x)));
  x += v + sum(scheme.x);
  v += sum(scheme.v);
}

/// The larger size of the eigenvalues of a step of the oscillator.
double amplification(const ExplicitScheme& scheme, double angle) {
  double xx = 1, vx = 0, xv = 0, vv = 1;
  stepOscillator(scheme, angle * angle, xx, vx);
  stepOscillator(scheme, angle * angle, xv, vv);
  const double half_trace = (xx + vv) / 2, determinant = xx * vv - xv * vx;
  const double discriminant = half_trace * half_trace - determinant;
  return discriminant < 0 ? std::sqrt(determinant) : std::abs(half_trace) + std::sqrt(discriminant);
}

}  // namespace

StabilityLimit stabilityLimit(const ExplicitScheme& scheme) {
  StabilityLimit limit;
  limit.grows = amplification(scheme, 0.1) > 1 + 1e-12;
  const double allowed = limit.grows ? 1.01 : 1 + 1e-9;
  constexpr double spacing = 1e-3;
  limit.largest_angle = spacing;
  while (limit.largest_angle < 10 && amplification(scheme, limit.largest_angle + spacing) <= allowed)
    limit.largest_angle += spacing;
  return limit;
}

// ---- the step ----

ExplicitStep::ExplicitStep() : parts_(std::make_unique<ExplicitParts>()) {}
ExplicitStep::~ExplicitStep() = default;
void ExplicitStep::stepTaken() { parts_->stepTaken(); }
void ExplicitStep::reset() { parts_->reset(); }
void ExplicitStep::serialize(Archive& archive) { parts_->serialize(archive); }

void ExplicitStep::compile(Integrator& integrator, System& system) {
  refuseRayleighFactors(system, scheme.name);
  acceleration_.compile(system, scheme.name);
  const StabilityLimit limit = stabilityLimit(scheme);
  parts_->compile(system, acceleration_, scheme.name, limit.largest_angle);
  accelerations_.clear();
  for (std::size_t j = 0; j < scheme.stages.size(); ++j) accelerations_.emplace_back(system.independentRows());
  for (Vector* vector : {&stage_x_, &stage_v_}) vector->resize(system.allRows());
  depends_on_time_ = false;  // compiled again after an edit
  for (const ForceField* field : system.forceFields())
    depends_on_time_ = depends_on_time_ || field->traits().time_dependent;
  rates_.clear();
  std::size_t turning = 0;
  for (const Index row : system.motion().turningRows()) turning += row < system.independentRows();
  if (scheme.stages.size() > 1 && turning > 0) rates_.assign(scheme.stages.size(), std::vector<Vec3>(turning));
  warnAboveStableStep(integrator, system, acceleration_, scheme.name, limit);
}

StepReport ExplicitStep::step(System& system, const StepContext& context) {
  if (!parts_->areNeeded()) return makePart(system, context, context);
  const auto make = [&](const StepContext& part) { return makePart(system, context, part); };
  return parts_->run(context, std::cref(make));  // takes no memory
}

StepReport ExplicitStep::makePart(System& system, const StepContext& whole, const StepContext& context) {
  StepReport report;
  const double h = context.dt;
  for (std::size_t i = 0; i < scheme.stages.size(); ++i) {
    const ExplicitScheme::Stage& stage = scheme.stages[i];
    if (depends_on_time_) system.setTime(context.t + stage.time * h);
    parts_->setTime(context.t + stage.time * h);
    // beginStep() has given what is moved the mean velocity of the step
    const bool is_start = i == 0 && !system.constraints().hasPrescribed();
    if (!is_start) placeStage(system, whole, context, stage);
    if (!is_start && parts_->areNeeded() && !parts_->isFree(system.independent(stage_x_))) return report;
    if (is_start && !rates_.empty())
      for (std::size_t k = 0; k < rates_[0].size(); ++k) rates_[0][k] = system.v[system.motion().turningRows()[k]];
    const ConstRows x = is_start ? system.x : stage_x_, v = is_start ? system.v : stage_v_;
    system.computeForce(x, v, system.f);
    const ConstRows f = system.independent(system.f);
    const Rows a = accelerations_[i];
    if (stepsMomenta(system) ? !acceleration_.solveForMomenta(x, f, a, context.stop, report)
                             : !acceleration_.solve(x, v, f, a, context.stop, report))
      return report;
  }
  if (depends_on_time_) system.setTime(context.t_end);
  parts_->setTime(context.t_end);
  const bool is_symplectic = scheme.stages.size() == 1 && scheme.x == scheme.v;
  finish(system, h, parts_->areNeeded() && is_symplectic ? (parts_->before(h) + h) / 2 : h);
  return report;
}

void ExplicitStep::placeStage(System& system, const StepContext& whole, const StepContext& context,
                              const ExplicitScheme::Stage& stage) {
  const double h = context.dt;
  const Rows x = system.independent(stage_x_), v = system.independent(stage_v_);
  copy(system.independent(system.x), x);
  copy(system.independent(system.v), v);
  orientations_.take(system.motion(), x);
  axpy(stage.time * h, v, x);
  for (std::size_t j = 0; j < stage.v.size(); ++j) {
    if (stage.x[j] != 0) axpy(h * h * stage.x[j], accelerations_[j], x);
    if (stage.v[j] != 0) axpy(h * stage.v[j], accelerations_[j], v);
  }
  if (!rates_.empty()) {
    setTurns(system, h, stage.v, x);
    noteRates(system, std::size_t(&stage - scheme.stages.data()));
  }
  orientations_.turn(x);
  // a motion in pieces changes its velocity at once between two of them: the ends of the step belong to the one within,
  // by more than what makes two times the same (key_times.h)
  const double margin = std::min(1e-10 * h + 1e-11 * std::abs(context.t_end), h / 4);
  const double inside = std::clamp(stage.time * h, margin, h - margin);
  system.constraints().placePrescribed(whole, context.t + inside, stage_x_, stage_v_);
}

void ExplicitStep::setTurns(const System& system, double h, const std::vector<double>& weights, Rows x) const {
  const std::vector<Index>& rows = system.motion().turningRows();
  for (std::size_t i = 0; i < rates_[0].size(); ++i) {
    x[rows[i]].setZero();
    for (std::size_t j = 0; j < weights.size(); ++j) x[rows[i]] += h * weights[j] * rates_[j][i];
  }
}

/// Where stage_x_ still has rotation vectors.
void ExplicitStep::noteRates(const System& system, std::size_t stage) {
  const std::vector<Index>& rows = system.motion().turningRows();
  for (std::size_t i = 0; i < rates_[stage].size(); ++i)
    rates_[stage][i] = dexpInverse(stage_x_[rows[i]]) * stage_v_[rows[i]];
}

/// The first acceleration together with h v0 in one pass, because most schemes have no other. `between`: h, or the time between two
/// velocities at the middle of parts.
void ExplicitStep::finish(System& system, double h, double between) {
  const Rows x = system.independent(system.x), v = system.independent(system.v);
  const double for_v = between * scheme.v[0], for_x = h * (between * scheme.x[0] - for_v);
  const double* __restrict a = accelerations_[0].rows().data;
  double* __restrict velocity = v.data;
  double* __restrict position = x.data;
  const TurningBodies& bodies = acceleration_.bodies();
  const bool steps_momenta = stepsMomenta(system) && !bodies.empty();
  momenta_.resize(steps_momenta ? bodies.count() : 0);
  for (std::size_t b = 0; b < momenta_.size(); ++b)
    momenta_[b] = bodies.times(b, x, v[bodies.row(b)] + for_v * accelerations_[0][bodies.row(b)]);
  orientations_.take(system.motion(), x);
#pragma omp simd
  for (std::size_t i = 0; i < x.doubles(); ++i) {
    velocity[i] += for_v * a[i];
    position[i] += h * velocity[i] + for_x * a[i];
  }
  for (std::size_t j = 1; j < accelerations_.size(); ++j) {
    if (scheme.x[j] != 0) axpy(h * h * scheme.x[j], accelerations_[j], x);
    if (scheme.v[j] != 0) axpy(h * scheme.v[j], accelerations_[j], v);
  }
  if (!rates_.empty()) setTurns(system, h, scheme.v, x);
  orientations_.turn(x);
  if (steps_momenta) bodies.setVelocities(x, momenta_, v);
}

std::string ExplicitStep::describe() const {
  const std::size_t count = scheme.stages.size();
  return fmt::format("{}: {} force evaluation{}, {}{}", scheme.name, count, count == 1 ? "" : "s", acceleration_.describe(),
                     parts_->describe());
}

// ---- the integrator ----

void ExplicitIntegrator::declare(DataTable& table) {
  declareLinearSolver(table, false);
  velocity_damping_.declare(table);
  sleep_.declare(table);
}

StepReport ExplicitIntegrator::step(System& system, const StepContext& context) {
  energy_.stepBegins();
  if (sleep_.passesOver(context)) return {};
  StepReport report = explicit_.step(system, context);
  velocity_damping_.apply(system, context.dt);
  return sleep_.judged(std::move(report));
}

void ExplicitIntegrator::compile(System& system) {
  explicit_.scheme = scheme();
  explicit_.compile(*this, system);
  sleep_.compile(system);
  energy_.compile(system, true);
}

}  // namespace stroma
