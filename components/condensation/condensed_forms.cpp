// SPDX-License-Identifier: LGPL-2.1-or-later
// Whether a whole body is solved by its sparse factor or by its inverse: the faster, measured.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <map>
#include <mutex>

#include "components/condensation/condensed_integrator.h"

namespace stroma {
namespace {

/// The least of many repetitions: other work of the machine only adds to it.
double leastSeconds(const std::function<void()>& work) {
  constexpr int fewest = 3, most = 100;
  constexpr double enough = 0.005;
  using Clock = std::chrono::steady_clock;
  work();  // brings into the caches what stays there from step to step
  double least = std::numeric_limits<double>::max(), sum = 0;
  for (int i = 0; i < most && (i < fewest || sum < enough); ++i) {
    const auto begin = Clock::now();
    work();
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    least = std::min(least, seconds);
    sum += seconds;
  }
  return least;
}

std::mutex remembering;

}  // namespace

// An estimate by bytes was wrong by a factor of up to four: what fits into a cache is read several times as fast, and
// sweeps through a factor of small pieces wait for other things than memory.
// The inverse is not there yet, and what its product takes does not depend on its numbers: a matrix of zeros stands in
// for it. An entry takes no less time in a large matrix than in a small one, so that small ones come first: they tell
// soon, and in little memory, where the inverse is out of the question.
void CondensedIntegrator::measureForms() {
  constexpr std::size_t smallest = 1024;  // from there on products are cut in pieces for threads
  const std::size_t unknowns = 3 * std::size_t(body_.free());
  Array<double> load(unknowns, 1.0), result(unknowns);
  measured_ = {};
  measured_.sweeps = leastSeconds([&] {
    std::copy(load.begin(), load.end(), result.begin());
    forward(result.data());
    backward(result.data());
  });
  if (!inverseFits()) return;
  for (std::size_t rows = 0; rows < unknowns && measured_.product < measured_.sweeps;) {
    rows = std::min(std::max(2 * rows, smallest), unknowns);
    const double ratio = double(unknowns) / double(rows);
    measured_.product = ratio * ratio * leastSeconds(trialProduct(rows));
    measured_.rows = double(rows);
  }
}

bool CondensedIntegrator::inverseFits() const {
  const std::size_t unknowns = 3 * std::size_t(body_.free()), number = isSingle() ? 4 : 8;
  // its own, those of the dense matrix from which it is made, and those of the sparse one
  // (PartialCholesky::peakBytes())
  const double sparse = 12 * 9. / 2 * (double(body_.stiffness().blocks()) + double(body_.free()));
  const double bytes =
      double(number * SymmetricPanels<double>::size(unknowns)) + 8 * double(unknowns * unknowns) + sparse;
  const double limit = memoryLimit();
  return limit == 0 || bytes <= limit;
}

bool CondensedIntegrator::inverseIsFaster() const {
  return measured_.rows == 3.0 * body_.free() && measured_.product < measured_.sweeps;
}

// ---- one choice in one process ----

// The two forms differ by round-off. A body that is loaded again gives the same bits, whatever the clock would say.
std::map<std::array<std::uint64_t, 2>, CondensedIntegrator::Measured>& CondensedIntegrator::remembered() {
  static std::map<std::array<std::uint64_t, 2>, Measured> all;
  return all;
}

bool CondensedIntegrator::recallForms(const ContentKey& key) {
  const std::lock_guard lock(remembering);
  const auto found = remembered().find(key.value());
  if (found == remembered().end() || !inverseFits()) return false;
  measured_ = found->second;
  if (inverseIsFaster()) used_form_ = Form::symmetric;
  return true;
}

void CondensedIntegrator::rememberForms(const ContentKey& key) const {
  const std::lock_guard lock(remembering);
  if (measured_.rows > 0) remembered()[key.value()] = measured_;
}

std::string CondensedIntegrator::measuredText() const {
  if (measured_.sweeps == 0) return {};
  const std::string sweeps =
      fmt::format("; measured when it was made: {:.3g} ms by the factor, ", 1e3 * measured_.sweeps);
  if (measured_.rows == 0) return sweeps + "and no memory for the inverse";
  return sweeps + fmt::format("{}{:.3g} ms by the inverse", measured_.rows < 3.0 * body_.free() ? "at least " : "",
                              1e3 * measured_.product);
}

}  // namespace stroma
