// SPDX-License-Identifier: LGPL-2.1-or-later
// A chain of beams between the rigid frames of a state: the interface of BeamInterpolation and WireBeamInterpolation for the
// forces, the inertia and the mappings of beams.
#pragma once
#include <optional>
#include <vector>

#include "framework/mechanics/frames.h"
#include "framework/mechanics/state_topology.h"

namespace stroma {

/// Material and section of a stretch of a rod. Moments of area of the section are those about its centre.
struct RodSection {
  double radius = 0;                              ///< [m], of a round one: drawn
  double area = 0;                                ///< A [m^2]
  double about_y = 0, about_z = 0;                ///< Iy, Iz [m^4]
  double young = 0, poisson = 0;                  ///< E [Pa], nu
  std::optional<double> density = std::nullopt;   ///< [kg/m^3], where it is given
  double polar() const { return about_y + about_z; }               ///< J [m^4]
  double shearModulus() const { return young / (2 * (1 + poisson)); }  ///< [Pa]
};
/// A = pi (r^2 - r_i^2), Iy = Iz = pi (r^4 - r_i^4)/4. Throws ComponentError unless r > r_i.
RodSection roundSection(double radius, double inner, double young, double poisson);

/// Where a frame is.
struct Placement {
  Vec3 centre = Vec3::Zero();
  Quaternion turn = Quaternion::Identity();
};

/// A beam on an edge of the chain's mesh. Its axes are fixed in the frames of its ends, x along the rod.
struct ChainBeam {
  Index a = 0, b = 0;        ///< nodes
  bool is_there = true;      ///< false: of a rod that is not out so far
  double length = 0;         ///< [m]
  double from = 0, to = 0;   ///< lengths of the rod where it begins and ends [m]
  RodSection section{};
  Quaternion axes_a = Quaternion::Identity(), axes_b = Quaternion::Identity();  ///< in the frames
  Vec3 rest_way = Vec3::Zero(), rest_turn = Vec3::Zero();  ///< of b in the axes of a, at rest [m], rotation vector [rad]
};

class BeamChain : public Component {
 public:
  std::string roleText() const override { return "interpolation of beams"; }
  void declare(DataTable& table) override;  ///< topology, beams
  void init() override;                     ///< finds the state and the mesh
  State& state() const { return *state_; }
  /// One for each edge that may carry a beam at any time: always the same edges in the same order.
  const std::vector<ChainBeam>& beams() const { return beams_; }
  /// Increases whenever the beams change.
  long revision() const { return revision_; }
  /// The length of the whole rod [m], in and out.
  virtual double wholeLength() const = 0;
  /// The rod in stretches of one section, in and out: `length`, `to` and `section` of each.
  virtual std::vector<ChainBeam> wholeRod() const { return beams_; }
  /// Called when all components are ready. Throws ComponentError where beams are missing.
  virtual void checkBeams() const {}
  /// A step begins: the deployed part of the rod may change, and frames with it.
  virtual void stepBegins(double /*t*/, double /*t_end*/) {}
  virtual bool isPushed() const { return false; }  ///< stepBegins() may do something
  /// A quantity is requested with the frames at x: at the start of a step that was rolled back, the beams are those of that
  /// time.
  virtual void askedAt(ConstRows /*x of the state*/) {}

 protected:
  const std::vector<Edge>& edges() const { return *edges_; }
  /// The initial or rest frames.
  Placement placementOf(Index node, bool at_rest) const;
  /// After each change of beams_.
  void publish();
  std::vector<ChainBeam> beams_;

 private:
  long revision_ = 0;
  std::vector<double> table_;  ///< of the attribute `beams`
  TopologyLink topology_;
  State* state_ = nullptr;
  const std::vector<Edge>* edges_ = nullptr;
};

}  // namespace stroma
