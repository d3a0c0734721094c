// SPDX-License-Identifier: LGPL-2.1-or-later
// Detects artificial energy growth: second-order rules with one linear solve per step and an approximate stiffness, and explicit rules
// with steps that are too long, can gain energy step by step without any single state looking
// wrong.
#pragma once
#include <string>

#include "framework/scene/archive.h"
#include "framework/simulation/system.h"

namespace stroma {

class EnergyWatch {
 public:
  /// Watches a system only if it is closed: nothing drives it, and nothing else acts on it.
  void compile(const System& system, bool wanted);
  /// Call it before a step.
  void stepBegins();
  void stepTaken();
  /// The scene has changed: the present energy is the new start.
  void forget() { taken_ = 0, most_kinetic_ = recent_ = early_ = 0; }
  /// The energy gained [J] up to the present state as a fraction of the largest kinetic energy, or 0 if it is within the usual error
  /// of the rule.
  double gained(double usual = 0.05) const;
  /// The warning of an explicit integrator, or empty. `of_middle`: its velocities are at the middle of steps.
  std::string doubtOfSteps(const std::string& path, bool of_middle) const;
  void serialize(Archive& archive) {
    archive.value("watched_steps", taken_);
    archive.value("start_energy", start_);
    archive.value("most_kinetic_energy", most_kinetic_);
    archive.value("recent_kinetic_energy", recent_);
    archive.value("early_kinetic_energy", early_);
  }

 private:
  double noise() const;
  double gainedSinceStart() const;
  double energy() const { return system_->kineticEnergy() + system_->potentialEnergy(system_->x); }
  const System* system_ = nullptr;  ///< null: nothing is watched
  long taken_ = 0;
  double start_ = 0, begun_ = 0;  ///< energy [J] at the start of the first step, and of a step that may be the first
  double most_kinetic_ = 0;       ///< [J], of some steps
  double recent_ = 0, early_ = 0;  ///< the same up to the last power of two, and up to the one before [steps]
};

}  // namespace stroma
