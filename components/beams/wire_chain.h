// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/beams/rod_shape.h"

namespace stroma {

/// Implemented by the components that push rods.
class MovesRods {
 public:
  virtual ~MovesRods() = default;
  /// A step from t to t_end [s]: assigns beams to the rods, and moves frames. Called for each rod.
  virtual void moveRods(double t, double t_end) = 0;
  /// The next requests to a rod (forces, energies, masses) are made at x. A step that moveRods() has begun may be rolled
  /// back: if x is the state before the step, the rods get the beams of before it; at any other x those that moveRods() has
  /// made.
  virtual void askedAt(ConstRows x) = 0;
  /// Edges of the chain of points that contacts act on; how many it takes where all rods are out.
  virtual int contactEdges(bool all_out) const = 0;
};

/// A rod that a controller pushes out: the role of WireBeamInterpolation.
class WireChain : public BeamChain {
 public:
  const RodShape& shape() const { return *shape_; }
  /// Sets the beams, one for each edge of the mesh.
  void setBeams(std::vector<ChainBeam> beams) { beams_ = std::move(beams), publish(); }
  void followOf(MovesRods& mover) { mover_ = &mover; }
  bool isPushed() const override { return mover_ != nullptr; }
  const std::vector<Edge>& allEdges() const { return edges(); }
  double wholeLength() const override { return shape_->length(); }
  std::vector<ChainBeam> wholeRod() const override {
    std::vector<ChainBeam> rod;
    for (const RodStretch& stretch : shape_->stretches()) {
      ChainBeam& part = rod.emplace_back();
      part.length = stretch.length, part.to = stretch.length + (rod.size() > 1 ? rod[rod.size() - 2].to : 0);
      part.section = stretch.section;
    }
    return rod;
  }
  void stepBegins(double t, double t_end) override {
    if (mover_) mover_->moveRods(t, t_end);
  }
  void askedAt(ConstRows x) override {
    if (mover_) mover_->askedAt(x);
  }
  /// Beams of edges that carry nothing.
  std::vector<ChainBeam> noBeams() const {
    std::vector<ChainBeam> none;
    for (const Edge& edge : edges()) none.push_back({edge[0], edge[1], false});
    return none;
  }

 protected:
  const RodShape* shape_ = nullptr;

 private:
  MovesRods* mover_ = nullptr;
};

}  // namespace stroma
