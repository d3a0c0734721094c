// SPDX-License-Identifier: LGPL-2.1-or-later
// What the condensed solvers compute once: the matrix, its factor and the inverse that is kept.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>

#include "components/condensation/condensed_problem.h"
#include "framework/scene/node.h"
#include "framework/simulation/long_work.h"

namespace stroma {
namespace {

double availableBytes() {
  std::ifstream info("/proc/meminfo");
  std::string word;
  double number = 0;
  while (info >> word)
    if (word == "MemAvailable:" && info >> number) return 1024 * number;
  return 0;
}

}  // namespace

void CondensedIntegrator::compile(System& system) {
  const auto begin = std::chrono::steady_clock::now();
  dt_ = node().root().dt();
  checkChoices();
  others_.collect(system, *this, rayleighMass());
  conditions_.others.assign(std::size_t(others_.count()), Vec3::Zero());
  body_.collect(system, others_, *this, {condensed_, surface_indices_, isDynamic()});
  Problem problem{system};
  for (const State* state : system.states()) asks_force_ = asks_force_ || state->forceRequested();
  problem.force = body_.constantForce();  // first: stiffnesses are those of the last force
  if (isDynamic()) {
    if (!(dt_ > 0)) throw ComponentError("the time step is not positive", "dt of the root node");
    problem.mass = body_.masses();
    const std::vector<double> own = body_.massDamping();
    for (std::size_t i = 0; i < own.size(); ++i) {
      problem.per_mass.push_back(1 / (dt_ * dt_) + (rayleighMass() + own[i]) / (2 * dt_));
      const bool has_inertia = keepsInteriorMass() || Index(i) >= body_.interior();
      problem.shift.push_back(has_inertia ? problem.mass[i] * problem.per_mass[i] : 0);
    }
  }
  used_form_ = form();
  problem.key = keyOf(problem);
  from_cache_ = loadStored(problem);
  if (!from_cache_) {
    problem.stiffness = body_.stiffness();
    computeFaster(problem);
  }
  body_.renumber(problem.order);
  shift_.clear();
  for (std::size_t i = 0; i < problem.shift.size(); ++i) shift_.push_back(problem.shift[problem.order[i]]);
  kept_count_ = used_form_ == Form::factor ? body_.free() : body_.kept();
  interior_count_ = body_.free() - kept_count_;
  prepareActive(system, problem.order, problem.force);
  for (const std::string& note : body_.notes()) inform(note);
  if (isSingle() && used_form_ == Form::factor)
    inform("precision=\"single\" has no effect: the sparse factor is used, which is in double precision");
  prepare(system);
  compileConditions(system);
  compileContact(system);
  if (!from_cache_) store(problem);
  precomputation_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

std::string CondensedIntegrator::sourcesOfNumbers() { return STROMA_SOURCES_OF_CONDENSATION; }

ContentKey CondensedIntegrator::keyOf(const Problem& problem) const {
  ContentKey key;
  key.add(fmt::format("condensed {} form {} {} precision {} interior {} masses {} {}", sourcesOfNumbers(), int(form()),
                      mayInvert(), int(precision_), body_.interior(), keepsInteriorMass(), sharesInteriorMass()));
  body_.addTo(key);
  key.add(problem.shift);
  key.add(problem.per_mass);
  key.add(problem.mass);  // the file has the inertia as well, and other masses may give the same matrix
  return key;
}

// The sparse factor comes first, because it takes a fraction of the time and memory that the inverse does: it is
// measured itself, and given up again where the inverse is faster.
void CondensedIntegrator::computeFaster(Problem& problem) {
  if (!mayInvert() || recallForms(problem.key)) return computeAnew(problem);
  computeAnew(problem);
  measureForms();
  rememberForms(problem.key);
  if (!inverseIsFaster()) return;
  used_form_ = Form::symmetric;
  computeAnew(problem);
}

double CondensedIntegrator::memoryLimit() const { return memory_limit_ > 0 ? 1e9 * memory_limit_ : availableBytes(); }

void CondensedIntegrator::refuseTooLarge(double bytes, const std::string& what) const {
  const double limit = memoryLimit();
  if (limit > 0 && bytes > limit)
    throw ComponentError(fmt::format("{} takes {:.2g} GB for {} kept nodes over {} inside, and {} GB are {}", what,
                                     1e-9 * bytes, body_.kept(), body_.interior(), fmt::format("{:.2g}", 1e-9 * limit),
                                     memory_limit_ > 0 ? "allowed by memoryLimit" : "available"),
                         condensed_ ? "fewer kept nodes (surfaceIndices)" : "condensed=\"true\"",
                         isSingle() ? "" : "precision=\"single\" halves the inverse");
}

void CondensedIntegrator::computeAnew(Problem& problem) {
  factor_ = makeFactor();
  const Index eliminated = used_form_ == Form::factor ? body_.free() : body_.interior();
  const std::size_t nodes = std::size_t(body_.free() - eliminated), number = isSingle() ? 4 : 8;
  const std::size_t count = used_form_ == Form::factor    ? 0
                            : used_form_ == Form::columns ? ColumnPanels<double>::size(nodes)
                                                          : SymmetricPanels<double>::size(3 * nodes);
  // before anything that is quadratic in the number of kept nodes: its factor alone, then all of it
  refuseTooLarge(double(count * number) + 8 * 9 * double(nodes) * double(nodes), "the inverse");
  problem.order = factor_->analyse(body_.matrix(problem.stiffness, problem.shift), eliminated);
  compliance_bytes_ = count * number;
  // a mass that is shared out by rows shifts a copy of the dense matrix
  const double kept_unknowns = 3.0 * double(nodes);
  const double copy_bytes = sharesInteriorMass() && used_form_ != Form::factor ? 8 * kept_unknowns * kept_unknowns : 0;
  refuseTooLarge(double(compliance_bytes_) + factor_->peakBytes() + copy_bytes, "the precomputation");
  const double kept = kept_unknowns;
  LongWork telling(used_form_ == Form::factor ? fmt::format("{}: the factor of {} nodes", path(), eliminated)
                                              : fmt::format("{}: {} kept nodes over {}", path(), nodes, eliminated),
                   factor_->flops() + kept * kept * kept);
  if (cache_folder_.empty()) telling.advise("cacheFolder=\"auto\" keeps the result for the next run");
  telling.say(0);
  const double before = factor_->flops() / (factor_->flops() + kept * kept * kept);
  const Index bad = factor_->factor([&](double share) { telling.say(before * share); });
  if (bad >= 0) refuseFree(problem.system, bad);
  eliminated_ = factor_->eliminated();
  sweep_work_.resize(eliminated_.longest());
  inertia_.clear();
  for (std::size_t i = 0; i < problem.mass.size(); ++i)
    for (int c = 0; c < 3; ++c) inertia_.push_back(problem.mass[problem.order[i]]);
  if (sharesInteriorMass() && used_form_ != Form::factor) shareInteriorMass(problem, *factor_);
  if (used_form_ == Form::factor) return;
  if (!insideIsActive() && !inertia_.empty()) inertia_.erase(inertia_.begin(), inertia_.begin() + 3 * eliminated);
  owned_compliance_.assign(compliance_bytes_ / sizeof(double) + 1, 0.0);
  packInverse(*factor_, [&](double share) { telling.say(before + (1 - before) * share); });
  compliance_ = owned_compliance_.data();
  Array<double>().swap(factor_->kept());
}

// Guyan's reduction T^T M T, T = -K_II^-1 K_IS, lumped by sums of rows, each direction by itself: a body that is moved
// as a whole keeps its mass. Sums that came out negative are left out. Nodes that slide have one mass for all their
// free directions, trace/rank: the matrix keeps them in their plane as long as what is added to it does.
void CondensedIntegrator::shareInteriorMass(const Problem& problem, PartialCholesky& factor) {
  const std::size_t inside = 3 * std::size_t(body_.interior()), all = 3 * std::size_t(body_.free());
  std::vector<double> moved(all), more(all - inside, 0.0), shift(all - inside);
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < all; ++i) moved[i] = i >= inside && i % 3 == c ? 1 : 0;
    backward(moved.data());
    double whole = 0, shared = 0;
    for (std::size_t i = 0; i < inside; ++i) {
      whole += inertia_[i] * moved[i] * moved[i];
      moved[i] *= inertia_[i];
    }
    std::fill(moved.begin() + std::ptrdiff_t(inside), moved.end(), 0.0);
    forward(moved.data());
    for (std::size_t i = inside + c; i < all; i += 3) shared += std::max(moved[i], 0.0);
    for (std::size_t i = inside + c; i < all && shared > 0; i += 3)
      more[i - inside] = std::max(moved[i], 0.0) * whole / shared;
  }
  for (std::size_t i = 0; i < more.size(); i += 3) {
    const Index old = problem.order[(inside + i) / 3];
    if (!body_.projector(old).isIdentity())
      std::fill_n(&more[i], 3, (more[i] + more[i + 1] + more[i + 2]) / body_.projector(old).trace());
    for (std::size_t c = i; c < i + 3; ++c) {
      inertia_[inside + c] += more[c];
      shift[c] = more[c] * problem.per_mass[old];
    }
  }
  if (!factor.shift(shift)) refuseFree(problem.system, problem.order[inside / 3]);
}

void CondensedIntegrator::packInverse(PartialCholesky& factor, const std::function<void(double)>& progress) {
  const std::size_t nodes = std::size_t(body_.kept());
  const auto pack = [&](auto* data) {
    using Number = std::remove_reference_t<decltype(*data)>;
    const ColumnPanels<Number> columns{data, nodes};
    const SymmetricPanels<Number> symmetric{data, 3 * nodes};
    factor.invert(
        [&](Index j0, Index count, const double* x, Index height) {
          for (std::size_t c = 0; c < std::size_t(count); ++c)
            for (std::size_t i = c; i < std::size_t(height); ++i) {
              const std::size_t row = std::size_t(j0) + i, column = std::size_t(j0) + c;
              const double value = x[c * std::size_t(height) + i];
              if (used_form_ == Form::columns) {
                data[columns.offset(row, column)] = data[columns.offset(column, row)] = Number(value);
              } else {
                const bool diagonal = row / lanes == column / lanes;
                data[symmetric.offset(row, column)] = Number(diagonal ? value / 2 : value);
                if (diagonal) data[symmetric.offset(column, row)] = Number(value / 2);
              }
            }
        },
        progress);
  };
  if (isSingle()) {
    pack(reinterpret_cast<float*>(owned_compliance_.data()));
  } else {
    pack(owned_compliance_.data());
  }
}

void CondensedIntegrator::refuseFree(System& system, Index node) const {
  throw ComponentError(fmt::format("the matrix is singular at {}: the body can move there without any force resisting",
                                   system.actors().describeRow(body_.row(node))),
                       "bodies that cannot move as a whole, and elements or masses at every node",
                       "hold some nodes, as with <FixedProjectiveConstraint indices=\"...\"/>");
}

// ---- what steps need ----

void CondensedIntegrator::prepareActive(System& system, const std::vector<Index>& new_order,
                                        const std::vector<double>& force) {
  first_active_ = insideIsActive() ? 0 : body_.interior();
  active_ = body_.free() - first_active_;
  active_rows_.clear(), damping_.clear();
  std::vector<Index> active_of_row(std::size_t(system.allRows()), -1);
  const std::vector<double> own = body_.massDamping();
  origin_.assign(padded(), 0.0);
  for (Index node = 0; node < active_; ++node) {
    const Index row = body_.row(first_active_ + node);
    active_rows_.push_back(row);
    active_of_row[row] = node;
    damping_.push_back(rayleighMass() + own[first_active_ + node]);
    Eigen::Map<Vec3>(origin_.data() + 3 * node) = body_.reference()[row];
  }
  force_.clear();
  for (const Index node : new_order)
    for (std::size_t c = 0; c < 3; ++c) force_.push_back(force[3 * std::size_t(node) + c]);
  sweepConstantForce();
  const auto& timed = body_.timedNodes();
  timed_reduced_.assign(!timed.empty() && timed.front() < first_active_ ? sweep_.size() : 0, 0.0);
  range_.compile(system, body_, active_of_row);
}

}  // namespace stroma
