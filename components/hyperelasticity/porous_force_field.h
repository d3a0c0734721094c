// SPDX-License-Identifier: LGPL-2.1-or-later
// The fluid in a tissue, whatever the kind of cell: attributes, couplings, what a run remembers.
// TetrahedronPorousForceField's page has the formulas.
#pragma once
#include <memory>

#include "components/hyperelasticity/darcy_flow.h"
#include "components/hyperelasticity/dense_coupling.h"
#include "components/hyperelasticity/porous_elements.h"
#include "components/hyperelasticity/pressure_swings.h"
#include "framework/mechanics/force_field.h"
#include "framework/mechanics/history.h"
#include "framework/mechanics/state_topology.h"

namespace stroma {

class PorousForceField : public ForceField, public History {
 public:
  void declare(DataTable& table) override;
  void init() override;
  ForceTraits traits() const override;
  void compile() override;
  void reset() override { start(initial_); }
  void serialize(Archive& archive) override;
  void setTime(double t) override;
  void stepEnded(double t) override;
  std::string fault() const override;
  std::string doubt(ConstRows x) const override;
  const std::vector<double>& history() const override { return pressure_; }

  double energy(ConstRows x) const override { return porous_ ? elements_->energy(x, now_) : 0; }
  void addForce(ConstRows x, ConstRows v, Rows f) override;
  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override;
  void addPattern(BlockPattern& pattern) const override;
  void prepareAssembly(const BlockMatrix& matrix) override;
  void addStiffness(double factor, BlockMatrix& matrix) const override;
  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override;
  Cost cost() const override;
  std::vector<std::string> cellFields() const override { return {"pressure"}; }
  void cellField(const std::string& name, ConstRows x, std::vector<double>& out) const override;
  CellFieldShape cellFieldShape(const std::string&) const override { return {&kind(), 1}; }

 protected:
  virtual const CellKind& kind() const = 0;
  /// The elements of these cells; `first_row`: of node 0.
  virtual std::unique_ptr<porous::PorousElements> makeElements(const porous::PorousCells& cells,
                                                               const porous::Sponge& sponge, Index first_row) const = 0;

 private:
  enum class Coupling : int { semi_implicit, implicit };
  enum class Tangent : int { coupled, undrained };
  bool flows() const { return coupling_ == Coupling::implicit && step_ > 0; }
  bool isCoupled() const { return coupling_ == Coupling::implicit && tangent_ == Tangent::coupled; }
  bool isSet(const char* attribute) const { return data().find(attribute)->isSet(); }
  void declareModuli(DataTable& table);
  void chooseStorage();
  void checkCells() const;
  void warnOfNoElasticity() const;
  std::string whySwings() const;
  std::string doubtOfJumps() const;
  void start(const std::vector<double>& values);
  /// out = P at the end of a step with volumes theta of nodes in `out`.
  void follow(Rows out) const;
  /// Up to date with the last force.
  porous::DenseCoupling& dense() const;
  Rows own(Rows all) const { return {all.data + std::size_t(state().firstRow()) * row_doubles, state().size()}; }
  ConstRows systemRows() const {
    return {state().x().data - std::size_t(state().firstRow()) * row_doubles, state().firstRow() + state().size()};
  }

  TopologyLink topology_;
  bool porous_ = true;
  porous::Sponge sponge_;
  double grain_modulus_ = 0, fluid_modulus_ = 0;  ///< K_s and K_f [Pa], where they give Biot's modulus
  double permeability_ = 0;
  std::vector<int> drained_;
  Coupling coupling_ = Coupling::semi_implicit;
  Tangent tangent_ = Tangent::coupled;
  std::string fluid_of_elements_;  ///< why an assembled matrix keeps the fluid in each element; empty: it does not
  std::vector<double> pressure_;  ///< at the end of the last step [Pa], shape (nodes)
  std::vector<double> initial_;

  std::unique_ptr<porous::PorousCells> cells_;
  std::unique_ptr<porous::PorousElements> elements_;
  mutable DarcyFlow flow_;
  std::unique_ptr<porous::DenseCoupling> dense_;  ///< of implicit coupling, for bodies of few nodes
  mutable bool dense_ready_ = false;
  std::vector<Index> slots_, dense_slots_;
  double time_ = 0, step_ = 0;  ///< [s], of pressure_; from there to the time of the forces
  bool started_ = false;        ///< theta_ is known
  std::vector<double> theta_;   ///< at the end of the last step [m^3], shape (nodes)
  porous::PressureSwings swings_;
  Vector now_;             ///< pressures that the forces see, shape (system rows)
  mutable Vector change_;  ///< work space, shape (system rows)
};

}  // namespace stroma
