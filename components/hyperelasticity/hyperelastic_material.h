// SPDX-License-Identifier: LGPL-2.1-or-later
// A material that stands in the scene as a component of its own: a law and its parameters, for the field that asks.
#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "components/hyperelasticity/hyperelastic_law.h"
#include "framework/scene/component.h"

namespace stroma {

class HyperelasticMaterial : public Component {
 public:
  std::string roleText() const override { return "hyperelastic material"; }
  /// Parameters have the names that they have in the scene.
  virtual hyperelastic::HyperelasticLaw law() const = 0;
  /// In the order of law().parameters.
  virtual std::vector<double> values() const = 0;
  /// `remake` is called where parameters are others; the first of each that follows, which may ask again while it is called.
  void follow(const Component& follower, std::function<void()> remake) {
    for (const auto& [known, call] : followers_)
      if (known == &follower) return;
    followers_.emplace_back(&follower, std::move(remake));
  }
  void recompile() override {
    init();
    for (const auto& [follower, remake] : followers_) remake();
  }

 private:
  std::vector<std::pair<const Component*, std::function<void()>>> followers_;
};

}  // namespace stroma
