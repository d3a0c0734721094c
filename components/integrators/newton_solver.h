// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "components/integrators/newton.h"
#include "framework/scene/component.h"

namespace stroma {

/// What a component calls the parameters of Newton's method, and its residual.
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
  const auto threshold = [&table](const char* name, double& member, const char* unit, const std::string& help) {
    table.add(name, member).help("converged when " + help + "; 0: not used").unit(unit).min(0);
  };
  const std::string residual = names.residual;
  table.add(names.iterations, settings.iterations)
      .help("largest number of iterations of one solve: a step, or a part of a divided one")
      .unit("-")
      .min(1);
  threshold(names.relative_residual, settings.relative_residual, "-",
            residual + " is below this times the larger of " + residual +
                " and the forces with reactions, both where the step starts");
  threshold(names.absolute_residual, settings.absolute_residual, names.unit, residual + " is below this");
  threshold(names.relative_correction, settings.relative_correction, "-",
            "the correction is below this times the displacement of the step");
  threshold(names.absolute_correction, settings.absolute_correction, "m", "the correction is below this");
}

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

}  // namespace stroma
