// SPDX-License-Identifier: LGPL-2.1-or-later
// Hands that reach into a running scene. What they do to bodies are inputs of the simulation (framework/simulation/
// input_forces.h), which records them.
//
//   pull, hold   f_i = k (target_i - x_i) - c v_i on each node of a patch; the targets move with the pointer
//   force        a total force, shared by the nodes
//   push         a sphere with centre o and radius r: f_i = k (o + r n_i - x_i) - c v_i on nodes inside, n_i = (x_i - o) / |x_i - o|;
//                which nodes and where they are pushed is decided before each step
//
// Without a stiffness from the page k is a fraction of the body's own at the patch, the mean over its nodes of tr(K_ii) / 3, so
// that a hand is as stiff as what it pulls, whatever the units; c = sqrt(k m) with the mass m of a node is half of what would
// damp it critically.
#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/view/body.h"

namespace stroma::view {

class Hands {
 public:
  Hands(Simulation& simulation, const Drawing& drawing) : simulation_(simulation), drawing_(drawing) {}

  /// "pull", "force", "push" and "release" of the page's messages. Throws ComponentError and nlohmann's errors with a
  /// sentence; nothing has changed then.
  void apply(int client, const nlohmann::json& order);
  /// A page is gone: so are its hands.
  void releaseAll(int client);
  /// The simulation has dropped all inputs.
  void forget() { hands_.clear(); }
  /// Spheres have to look before each step at what they touch: updatePushes().
  bool pushes() const;
  void updatePushes();
  /// Of every hand, where it is and its force on the body [N] at the present state; for frames.
  nlohmann::json describe() const;
  /// After a step, or without one when the run stands still: the last order of each client takes effect in what is drawn.
  void orderedIsDrawn() { drawn_ = ordered_; }
  /// By client: the "sequence" of its last order that has taken effect.
  const std::map<int, long>& drawn() const { return drawn_; }

 private:
  struct Hand {
    std::string kind;  ///< pull, hold, force, push
    Index body = 0;
    long input = 0;  ///< its number; 0: nothing is touched now
    Input what{};    ///< the last input
    Vec3 centre = Vec3::Zero();
    double radius = 0;
  };
  using Key = std::pair<int, std::string>;  ///< client, name of the hand

  Hand pulling(const nlohmann::json& order, const Hand* before) const;
  Hand pushing(const nlohmann::json& order, const Hand* before) const;
  void touch(Hand& hand);
  void set(Hand& hand);
  void release(Hand& hand);
  const Body& bodyOf(const nlohmann::json& order, Index& number) const;
  /// Fills in stiffness and damping that the page leaves to us.
  void chooseStiffness(const Body& body, const std::vector<Index>& nodes, double factor, Input& input) const;
  Vec3 forceOn(const Hand& hand) const;

  Simulation& simulation_;
  const Drawing& drawing_;
  std::map<Key, Hand> hands_;
  std::map<int, long> ordered_, drawn_;
};

}  // namespace stroma::view
