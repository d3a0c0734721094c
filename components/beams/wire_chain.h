// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/beams/rod_shape.h"

namespace stroma {

/// Implemented by what pushes rods.
class MovesRods {
 public:
  virtual ~MovesRods() = default;
  /// A step from t to t_end [s]: gives beams to the rods, and moves frames. Called for each rod.
  virtual void moveRods(double t, double t_end) = 0;
};

/// A rod that comes out as a controller pushes it: the role of WireBeamInterpolation.
class WireChain : public BeamChain {
 public:
  const RodShape& shape() const { return *shape_; }
  /// From now on the beams are these, one for each edge of the mesh.
  void setBeams(std::vector<ChainBeam> beams) { beams_ = std::move(beams), publish(); }
  void followOf(MovesRods& mover) { mover_ = &mover; }
  bool isPushed() const override { return mover_ != nullptr; }
  const std::vector<Edge>& allEdges() const { return edges(); }
  double wholeLength() const override { return shape_->length(); }
  RodSection usualSection() const override { return shape_->stretches().front().section; }
  void stepBegins(double t, double t_end) override {
    if (mover_) mover_->moveRods(t, t_end);
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
