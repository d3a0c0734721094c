// SPDX-License-Identifier: LGPL-2.1-or-later
// Hands that reach into a running scene. What they do to bodies are inputs of the simulation (framework/simulation/
// input_forces.h), which records them.
//
//   pull, hold   f_i = k (target_i - x_i) - c v_i on each node of a patch; the targets move with the pointer
//   of frames    the same of their orientations: a torque k log(q_target q^-1) - c w
//   force        a total force, shared by the nodes
//   push         a ball with centre o and radius r: f_i = k (r - d_i) n_i - c (v_i . n_i) n_i on nodes inside,
//                d_i = |x_i - o|, n_i = (x_i - o) / d_i
//
// Without a stiffness from the page k is a fraction of the body's own at the patch, the mean over its nodes of tr(K_ii) / 3, so
// that a hand is as stiff as what it pulls, whatever the units; c = sqrt(k m) with the mass m of a node is half of what would
// damp it critically. Explicit integrators are not made unstable: there k is at most m / (2 dt)^2.
#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/session/mesh_changes.h"
#include "tools/view/drawn.h"

namespace stroma::view {

class Hands {
 public:
  Hands(Simulation& simulation, const Drawing& drawing) : simulation_(simulation), drawing_(drawing) {}

  /// "pull", "force", "push" and "release" of the page's messages. Throws ComponentError and nlohmann's errors with a
  /// sentence; nothing has changed then. Releasing a hand that there is not is no mistake: a reset lets all go.
  void apply(int client, const nlohmann::json& order);
  /// A page is gone: so are its hands.
  void releaseAll(int client);
  /// Meshes have changed, and with them the drawing: hands hold what is left of their nodes, as their inputs do.
  void follow(const NodesNow& now);
  /// The simulation has dropped all inputs.
  void forget() { hands_.clear(); }
  /// Of every hand, where it is and its force on the body [N] at the present state; for frames.
  nlohmann::json describe() const;
  /// An order of a client that is no hand's.
  void ordered(int client, long sequence) { ordered_[client] = sequence; }
  /// After a step, or without one when the run stands still: the last order of each client takes effect in what is drawn.
  void orderedIsDrawn() { drawn_ = ordered_; }
  /// By client: the "sequence" of its last order that has taken effect.
  const std::map<int, long>& drawn() const { return drawn_; }

 private:
  struct Hand {
    std::string kind;  ///< pull, hold, force, push
    Index body = 0;
    long input = 0;  ///< its number
    Input what{};    ///< the last one
  };
  using Key = std::pair<int, std::string>;  ///< client, name of the hand

  Hand pulling(const nlohmann::json& order, const Hand* before) const;
  Hand pushing(const nlohmann::json& order, const Hand* before) const;
  std::vector<Index> nodesOf(const nlohmann::json& order, const Body& body) const;
  std::vector<Index> turnsOf(const nlohmann::json& order, const Body& body) const;
  const Body& bodyOf(const nlohmann::json& order, Index& number) const;
  /// Fills in stiffness and damping that the page leaves to us. While it is held a hand keeps them: only targets move, and
  /// no matrix is made again.
  void chooseStiffness(const Body& body, const std::vector<Index>& nodes, const nlohmann::json& order,
                       const Hand* before, Hand& hand) const;
  /// Mean over the nodes of tr(K_ii) / 3 [N/m] of the scene's force fields; zero where there is none.
  double ownStiffness(const Body& body, const std::vector<Index>& nodes) const;
  /// On the body at the present state [N], and how many nodes it acts on.
  Vec3 forceOn(const Hand& hand, std::size_t& touched) const;

  Simulation& simulation_;
  const Drawing& drawing_;
  std::map<Key, Hand> hands_;
  std::map<int, long> ordered_, drawn_;
};

}  // namespace stroma::view
