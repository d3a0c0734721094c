// SPDX-License-Identifier: LGPL-2.1-or-later
// What a rule of second order gains where one linear solve with a stiffness that is an approximation is all that a scene allows
// a step, and explicit rules in steps that are too long: energy that comes from nowhere, step by step, and is not seen in any
// single state.
#pragma once
#include <string>

#include "framework/scene/archive.h"
#include "framework/simulation/system.h"

namespace stroma {

class EnergyWatch {
 public:
  /// Watches where all energy is the system's own: nothing drives it, and nothing else acts on it.
  void compile(const System& system, bool wanted);
  /// Before a step.
  void stepBegins();
  void stepTaken();
  /// The scene has changed: what it is now is the start.
  void forget() { taken_ = 0, most_kinetic_ = recent_ = early_ = 0; }
  /// Energy [J] that came from nowhere up to the present state, or 0 where it is no more than a rule's usual error, as a share of the
  /// most that has been in motion.
  double gained(double usual = 0.05) const;
  /// What an explicit integrator says of it, or empty. `of_middle`: its velocities are those of the middle of steps.
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
  double start_ = 0, begun_ = 0;  ///< energy [J] where the first step, and one that may be the first, began
  double most_kinetic_ = 0;       ///< [J], of some steps
  double recent_ = 0, early_ = 0;  ///< that up to the last power of two, and up to the one before [steps]
};

}  // namespace stroma
