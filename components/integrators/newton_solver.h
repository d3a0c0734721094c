// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "components/integrators/newton.h"
#include "framework/scene/archive.h"
#include "framework/scene/component.h"

namespace stroma {

/// The names of a component's Newton parameters, and of its residual.
struct NewtonNames {
  const char* iterations;
  const char* relative_residual;
  const char* absolute_residual;
  const char* relative_correction;
  const char* absolute_correction;
  const char* residual;  ///< the symbol of R in the help
  const char* unit;      ///< of R
};

inline void declareNewton(DataTable& table, NewtonSettings& settings, const NewtonNames& names) {
  const auto threshold = [&table](const char* name, double& member, const char* unit, const std::string& help) -> Data& {
    return table.add(name, member).help("converged when " + help + "; 0: not used").unit(unit).min(0);
  };
  const std::string residual = names.residual;
  table.add(names.iterations, settings.iterations)
      .help("largest number of iterations of one solve: a step, or a part of a divided one")
      .unit("-")
      .min(1);
  threshold(names.relative_residual, settings.relative_residual, "-",
            residual + " is below this times the larger of " + residual +
                " and the forces with reactions, both where the step starts")
      .max(1, false);
  threshold(names.absolute_residual, settings.absolute_residual, names.unit, residual + " is below this");
  threshold(names.relative_correction, settings.relative_correction, "-",
            "the correction is below this times the displacement of the step")
      .max(1, false);
  threshold(names.absolute_correction, settings.absolute_correction, "m", "the correction is below this");
}

/// `residual`: what it limits, for the help; `usual`: when the default is 0.1.
inline void declareForcing(DataTable& table, const char* name, NewtonSettings& settings, const std::string& residual,
                           const std::string& usual) {
  table.add(name, settings.forcing)
      .help(fmt::format("largest {} that linear solves by products may leave in early Newton iterations; 0: the linear solver's "
                        "own tolerance. Not written: 0.1 {} and forces are not linear, else 0",
                        residual, usual))
      .unit("-")
      .min(0)
      .max(1, false);
}

/// Warnings about converged static steps: those that did not move although forces were out of balance, because an absolute
/// threshold exceeds the forces; and unstable equilibria, whose stiffness has a negative direction.
class StaticDoubts {
 public:
  /// Forces at round-off, as reported by `hasForces`, need no balance.
  template <class HasForces>
  void noteUnmoved(const StepReport& report, const NewtonSettings& settings, const HasForces& hasForces) {
    const bool is_unmoved = !report.failed() && report.newton_iterations == 0;
    if (is_unmoved && settings.absolute_residual + settings.absolute_correction > 0 && hasForces())
      largest_ = std::max(largest_, report.newton_residual);
  }
  /// Factors of symmetric matrices reveal such a direction; with others Newton searches for one. It is only meaningful close to the
  /// equilibrium, and if the stiffness is the derivative of the forces. `residuals` [N]: of each iteration of the step that ends at t.
  /// `is_seen`: Newton::isUnstable().
  void noteStability(const StepReport& report, bool is_derivative, bool is_seen, const std::vector<double>& residuals, double t) {
    constexpr double close = 0.01;
    if (!report.newton_converged || !(is_seen || report.linear_stop == SolveStop::not_definite) || !is_derivative) return;
    const bool is_close = is_seen || (residuals.size() > 1 && residuals[residuals.size() - 2] < close * residuals.front());
    if (is_close && unstable_++ == 0) first_unstable_ = t;
  }
  void serialize(Archive& archive) {
    archive.value("unmoved", largest_);
    archive.value("unstable", unstable_);
    archive.value("first_unstable", first_unstable_);
  }
  /// The warnings, or empty.
  std::string doubt(const std::string& path) const {
    constexpr double much = 0.03;
    std::string unmoved, unstable;
    if (largest_ > much)
      unmoved = fmt::format(
          "{}: a step is taken as solved at its start, with {:.0f} % of the forces out of balance, because a threshold of Newton's "
          "method is above them",
          path, 100 * largest_);
    if (unstable_ > 0)
      unstable = fmt::format(
          "{}: the equilibrium of {}, at t = {:g} s first, may be unstable, as a straight column beyond its buckling load: the stiffness "
          "has a direction in which the body is pushed on. A small load from the side, or steps in time, show where it goes",
          path, unstable_ == 1 ? "a step" : fmt::format("{} steps", unstable_), first_unstable_);
    return unmoved + (unmoved.empty() || unstable.empty() ? "" : ". ") + unstable;
  }

 private:
  double largest_ = 0;         ///< largest relative residual of a step that did not move
  int unstable_ = 0;           ///< number of steps
  double first_unstable_ = 0;  ///< [s]
};

/// The role of a component that holds the settings of Newton's method for an integrator, and shows how it ended.
class NewtonSolver : public Component {
 public:
  std::string roleText() const override { return "Newton solver"; }
  /// Complete but for use_energy, which is the problem's.
  virtual NewtonSettings settings() const = 0;
  /// Called once, before any step, with the most values that noteResult() will bring.
  virtual void prepare(std::size_t values) = 0;
  virtual void noteResult(const StepReport& report, const Newton& newton) = 0;
};

/// The one that an integrator's link names, else the one of its node; null when there is none.
inline NewtonSolver* findNewtonSolver(const Component& integrator, const Link<NewtonSolver>& link) {
  return link.target() ? link.get() : integrator.find<NewtonSolver>();
}

/// Of statics beside one: which of two places holds must not be a guess.
inline void refuseSettingsBeside(const Component& statics, const NewtonSolver& settings) {
  for (const Data& attribute : statics.data().all())
    if (attribute.isSet() && !attribute.link())
      if (attribute.name().find("threshold") != std::string::npos || attribute.name() == "newton_iterations")
        throw ComponentError(fmt::format("{} is set here, but {} has the settings of Newton's method", attribute.name(),
                                         settings.path()),
                             "the settings in one of the two");
}

}  // namespace stroma
