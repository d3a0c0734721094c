// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/mechanics/mapping.h"

namespace stroma {

/// A mapping from the state of a node above to that of its own, by SOFA's attributes.
class LinkedMapping : public Mapping {
 public:
  void declare(DataTable& table) override;  ///< input, output and SOFA's switches
  void init() override;                     ///< finds both states
  void compile() override;
  State& input() const override { return *parents_.front(); }
  std::vector<State*> inputs() const override { return parents_; }
  State& output() const override { return *child_; }

 protected:
  /// True where `input` may name several states.
  virtual bool takesManyInputs() const { return false; }

 private:
  std::vector<State*> parents_;
  State* child_ = nullptr;
  LinkList<State> input_{"mechanical state"};
  Link<State> output_{"mechanical state"};
  bool maps_forces_ = true, maps_constraints_ = true, maps_masses_ = true, maps_matrices_ = false;
};

/// How a mapping that is not linear turns the force on its child into a stiffness.
enum class GeometricStiffness {
  none,       ///< left out
  exact,      ///< dJ^T/dx f
  stabilized  ///< the part of it that resists
};
/// Declares geometricStiffness.
void declareGeometricStiffness(DataTable& table, GeometricStiffness& choice, bool with_stabilized);

/// Declares convectiveInertia: whether addCurvature() adds anything.
void declareConvection(DataTable& table, bool& convects);

/// What such mappings share: blocks of their geometric stiffness, each between two rows of parents.
class CurvedMapping : public LinkedMapping {
 public:
  void declare(DataTable& table) override;  ///< convectiveInertia besides
  bool isLinear() const override { return false; }
  void addGeometricProduct(ConstRows f, ConstRows dx, double factor, Rows df) const override;
  void addGeometricPattern(BlockPattern& pattern) const override;
  void addGeometricStiffness(ConstRows f, double factor, BlockMatrix& matrix) const override;

 protected:
  struct Block {
    Index row = 0, column = 0;  ///< of the system
    Mat3 value = Mat3::Zero();
  };
  /// The blocks at the x of the last apply(), always of the same rows in the same order: of the symmetric part of dJ^T/dx
  /// f. What is left out is half of the torque on a frame times its turn, 1/2 [torque], so that all that acts on a frame in
  /// equilibrium leaves nothing out.
  virtual void geometricBlocks(ConstRows f, std::vector<Block>& out) const = 0;
  bool convects() const { return convects_; }

 private:
  mutable std::vector<Block> blocks_;
  bool convects_ = true;
};

}  // namespace stroma
