// SPDX-License-Identifier: LGPL-2.1-or-later
// The shape of a rod at rest, its sections and its subdivision, as functions of the length from its handle.
#pragma once
#include <vector>

#include "components/beams/beam_chain.h"
#include "framework/mesh/topology.h"

namespace stroma {

/// A stretch of a rod. At rest it is straight along x, or a helix about y,
///   theta = 2 pi s/l,   l^2 = h^2 + (pi D)^2,   place = (D/2 sin theta, h s/l, D/2 (cos theta - 1))
/// whose axes are turned by theta about y after atan(h/(pi D)) about z.
struct RodStretch {
  double length = 1;        ///< [m]
  RodSection section{};
  double diameter = 0;      ///< D of the helix [m]; 0: straight
  double height = 0;        ///< h, along the axis of the helix in each turn [m]
  int beams = 1;            ///< how many at least, where it is out
  int drawn_edges = 10, contact_edges = 20;
  /// At the length s from its beginning.
  Placement at(double s) const;
  double turnPerLength() const;  ///< [rad/m]
};

/// Implemented by components that describe a stretch.
class HasRodStretch : public Component {
 public:
  std::string roleText() const override { return "stretch of a rod"; }
  virtual const RodStretch& stretch() const = 0;
};

/// The role of WireRestShape. Lengths [m] are measured from the handle.
class RodShape : public TopologicalMapping {
 public:
  std::string roleText() const override { return "shape of a rod"; }
  bool answersLookup() const override { return false; }  ///< its mesh is for a container: beside it may stand that of the frames
  double length() const { return key_points_.back(); }
  /// The ends of the stretches, ascending from 0.
  const std::vector<double>& keyPoints() const { return key_points_; }
  const std::vector<RodStretch>& stretches() const { return stretches_; }
  const RodStretch& stretchAt(double at) const { return stretches_[stretchOf(at)]; }
  /// The beginning of a stretch belongs to the one before it.
  Placement restAt(double at) const;
  /// A beam from one length to another, at rest: everything except its nodes.
  void fill(ChainBeam& beam, double from, double to) const;

 protected:
  /// In init(): consecutive stretches, at least one.
  void setStretches(std::vector<RodStretch> stretches);
  std::vector<double> key_points_;

 private:
  std::size_t stretchOf(double at) const;
  std::vector<RodStretch> stretches_;
  std::vector<Placement> starts_;  ///< of stretches
};

}  // namespace stroma
