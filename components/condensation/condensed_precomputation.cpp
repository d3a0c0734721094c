// SPDX-License-Identifier: LGPL-2.1-or-later
// What the condensed solvers compute once: the matrix, its factor, the inverse that is kept, and the files they go to.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "components/condensation/condensed_integrator.h"
#include "framework/scene/node.h"
#include "framework/simulation/long_work.h"

namespace stroma {

/// What the precomputation depends on.
struct CondensedIntegrator::Problem {
  System& system;
  BlockMatrix stiffness{};
  std::vector<double> shift{};             ///< of the diagonal [N/m]
  std::vector<double> mass{}, per_mass{};  ///< m_i [kg] and 1/dt^2 + alpha_i/2dt [1/s^2] of free nodes
  std::vector<double> force{};             ///< constant loads, shape (free, 3)
  std::vector<Index> order{};
  ContentKey key{};
};

namespace {

/// Sections of a file. The constant loads of the run that wrote it and what became of them are `force`, `swept` and
/// `based`; `measured` says why it has an inverse or none.
enum Part : std::size_t {
  inverse,
  order,
  inertias,
  first,
  row_start,
  start,
  rows,
  values,
  force,
  swept,
  based,
  measured,
  parts
};

double availableBytes() {
  std::ifstream info("/proc/meminfo");
  std::string word;
  double number = 0;
  while (info >> word)
    if (word == "MemAvailable:" && info >> number) return 1024 * number;
  return 0;
}

template <class T>
Section sectionOf(const T* data, std::size_t count) {
  return {data, count * sizeof(T)};
}

}  // namespace

void CondensedIntegrator::compile(System& system) {
  const auto begin = std::chrono::steady_clock::now();
  dt_ = node().root().dt();
  checkChoices();
  body_.collect(system, *this, {condensed_, surface_indices_, isDynamic()});
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
  if (!from_cache_) store(problem);
  precomputation_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (!from_cache_ && cache_folder_.empty() && precomputation_ > 5)
    inform(fmt::format("the precomputation took {:.0f} s; cacheFolder=\"auto\" keeps it for the next run",
                       precomputation_));
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

// ---- files ----

std::string CondensedIntegrator::cacheFolder() const {
  if (cache_folder_ != "auto") return cache_folder_;
  if (const char* folder = std::getenv("XDG_CACHE_HOME"); folder && *folder) return std::string(folder) + "/stroma";
  const char* home = std::getenv("HOME");
  return home && *home ? std::string(home) + "/.cache/stroma" : "";
}

bool CondensedIntegrator::loadStored(Problem& problem) {
  file_name_.clear();
  if (cache_folder_.empty()) return false;
  const std::string folder = cacheFolder();
  if (folder.empty()) {
    warn("cacheFolder=\"auto\" finds no folder, since neither XDG_CACHE_HOME nor HOME is set: nothing is kept",
         "cacheFolder=\"a folder\"");
    return false;
  }
  file_name_ = fmt::format("{}/{}.condensed", folder, problem.key.text());
  std::string reason;
  const bool opened = file_.open(file_name_, problem.key, parts, reason);
  if (opened && mayInvert() && file_.section(inverse).bytes > 0) used_form_ = Form::symmetric;
  if (opened)
    for (std::size_t i = 0; i < parts && reason.empty(); ++i)
      if (i != inverse && (i != values || insideIsActive()) && !file_.isIntact(i)) reason = "its numbers are damaged";
  if (opened && reason.empty() && !inverseIsIntact(problem)) reason = "its numbers are damaged";
  if (!reason.empty()) {
    file_.close();
    used_form_ = form();
    warn(fmt::format("{} is not used and made anew: {}", file_name_, reason));
  }
  if (file_.isOpen()) useStored(problem);
  return file_.isOpen();
}

// Columns of a static body that no load can reach are never read, and so not checked.
bool CondensedIntegrator::inverseIsIntact(const Problem& problem) const {
  if (body_.kept() == 0) return true;
  const auto* new_order = file_.array<Index>(order);
  const auto* known_force = file_.array<double>(force);
  const std::vector<Index>& timed = body_.timedNodes();
  bool all = used_form_ != Form::columns || file_.section(force).bytes != problem.force.size() * sizeof(double) ||
             (!timed.empty() && timed.front() < body_.interior());
  for (std::size_t i = 0; i < problem.force.size() && !all; ++i)
    all = problem.force[3 * std::size_t(new_order[i / 3]) + i % 3] != known_force[i];
  if (all) return file_.isIntact(inverse);
  const std::size_t bytes = file_.section(inverse).bytes / std::size_t(body_.kept());
  for (Index node = body_.interior(); node < body_.free(); ++node) {
    const Index old = new_order[node];
    const bool is_read = std::binary_search(timed.begin(), timed.end(), old) ||
                         (body_.movingRows() && (*body_.movingRows())[body_.row(old)]);
    if (is_read && !file_.isIntact(inverse, std::size_t(node - body_.interior()) * bytes, bytes)) return false;
  }
  return true;
}

void CondensedIntegrator::store(const Problem& problem) {
  if (file_name_.empty()) return;
  const std::size_t count = std::size_t(eliminated_.supernodes);
  const std::vector<Section> sections{{compliance_, compliance_bytes_},
                                      sectionOf(problem.order.data(), problem.order.size()),
                                      sectionOf(inertia_.data(), inertia_.size()),
                                      sectionOf(eliminated_.first, count + 1),
                                      sectionOf(eliminated_.row_start, count + 1),
                                      sectionOf(eliminated_.start, count + 1),
                                      sectionOf(eliminated_.rows, std::size_t(eliminated_.row_start[count])),
                                      sectionOf(eliminated_.values, eliminated_.entries()),
                                      sectionOf(force_.data(), force_.size()),
                                      sectionOf(swept_.data(), swept_.size()),
                                      sectionOf(base_.data(), base_.size()),
                                      sectionOf(&measured_, 1)};
  const std::string reason = SectionFile::write(file_name_, problem.key, sections);
  if (!reason.empty()) warn(fmt::format("{} cannot be written ({}): the next run computes again", file_name_, reason));
}

void CondensedIntegrator::useStored(Problem& problem) {
  const auto* new_order = file_.array<Index>(order);
  problem.order.assign(new_order, new_order + body_.free());
  const Section stored = file_.section(inertias);
  const auto* numbers = static_cast<const double*>(stored.data);
  const std::size_t count = stored.bytes / sizeof(double);
  inertia_.assign(numbers, numbers + count);
  compliance_ = file_.section(inverse).data;
  compliance_bytes_ = file_.section(inverse).bytes;
  eliminated_ = {Index(file_.section(first).bytes / sizeof(std::int32_t)) - 1,
                 file_.array<std::int32_t>(first),
                 file_.array<std::int64_t>(row_start),
                 file_.array<std::int64_t>(start),
                 file_.array<std::int32_t>(rows),
                 file_.array<double>(values)};
  sweep_work_.resize(eliminated_.longest());
  measured_ = *file_.array<Measured>(measured);
}

// The factor of the inside is the larger part of a file and not needed for steps: it is checked when somebody needs it.
// Making it anew takes what a start without a file would take for it, in the middle of a run, and is refused alike.
void CondensedIntegrator::checkFactor() {
  if (!file_.isOpen() || insideIsActive() || factor_checked_) return;
  if (file_.isIntact(values)) {
    factor_checked_ = true;
    return;
  }
  factor_ = makeFactor();
  factor_->analyse(body_.matrix(body_.stiffness(), shift_), body_.interior(), true);
  const double bytes = factor_->peakBytes();
  if (const double limit = memoryLimit(); limit > 0 && bytes > limit)
    throw ComponentError(
        fmt::format(
            "the factor of the inside is damaged in {}, and to make it anew takes {:.2g} GB where {:.2g} GB are {}",
            file_name_, 1e-9 * bytes, 1e-9 * limit, memory_limit_ > 0 ? "allowed by memoryLimit" : "available"),
        "more memory", "remove the file, and the next run makes it anew before its first step");
  std::error_code ignored;
  std::filesystem::remove(file_name_, ignored);
  warn(
      fmt::format("the factor of the inside in {} is damaged: made anew, which takes {:.2g} GB, and so is the file in "
                  "the next run",
                  file_name_, 1e-9 * bytes));
  LongWork telling(fmt::format("{}: the factor of {} nodes inside", path(), body_.interior()), factor_->flops());
  telling.say(0);
  factor_->factor([&](double share) { telling.say(share); });
  eliminated_ = factor_->eliminated();
  Array<double>().swap(factor_->kept());
  factor_checked_ = true;
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

// Constant loads on the inside reach the kept nodes, f*_s = f_s - K_si K_ii^-1 f_i. A file has the result for the loads
// of the run that wrote it.
void CondensedIntegrator::sweepConstantForce() {
  const std::size_t inside = 3 * std::size_t(first_active_), all = force_.size();
  base_.clear();
  swept_.assign(force_.begin(), force_.end());
  const bool known = file_.isOpen() && file_.section(force).bytes == all * sizeof(double) &&
                     std::equal(force_.begin(), force_.end(), file_.array<double>(force));
  if (known) {
    std::copy_n(file_.array<double>(swept), all, swept_.begin());
    const std::size_t count = file_.section(based).bytes / sizeof(double);
    base_.assign(file_.array<double>(based), file_.array<double>(based) + count);
  } else if (std::any_of(force_.begin(), force_.begin() + std::ptrdiff_t(inside), [](double f) { return f != 0; })) {
    checkFactor();
    forward(swept_.data());
  }
  sweep_.assign(all, 0.0);
  interior_constant_.assign(swept_.begin(), swept_.begin() + std::ptrdiff_t(inside));
  constant_force_.assign(padded(), 0.0);
  std::copy(swept_.begin() + std::ptrdiff_t(inside), swept_.end(), constant_force_.begin());
}

}  // namespace stroma
