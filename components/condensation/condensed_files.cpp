// SPDX-License-Identifier: LGPL-2.1-or-later
// The files of the condensed solvers: what they keep of a precomputation, and what is done with a file that is there.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "components/condensation/condensed_problem.h"
#include "framework/simulation/long_work.h"

namespace stroma {
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

template <class T>
Section sectionOf(const T* data, std::size_t count) {
  return {data, count * sizeof(T)};
}

}  // namespace

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
    warn("cacheFolder=\"auto\" finds no folder, since neither XDG_CACHE_HOME nor HOME is set: nothing is cached",
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
    warn(fmt::format("{} is not used but computed again: {}", file_name_, reason));
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
        "more memory", "remove the file; the next run computes it again before its first step");
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
