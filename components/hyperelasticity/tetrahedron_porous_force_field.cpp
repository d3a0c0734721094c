// SPDX-License-Identifier: LGPL-2.1-or-later
// TetrahedronPorousForceField: the fluid in a tissue, as a sponge holds it. Added to any elastic tetrahedra of a node.
//
// A share f_w of the tissue is fluid that can leave; the rest cannot be compressed. The effective volume ratio is
// J* = (f_w + J - 1)/f_w, and the tissue resists with Hencky's Cauchy stress and the fluid's pressure P:
//
//   sigma = (sigma_H - P) Id,   sigma_H = K_0 f_w ln J*,   f_i = -V_0 (sigma_H - P) cof F G_i
//
// sigma_H is infinite at J = 1 - f_w: below J_0 = 1 - f_w + K_0/K_lim its tangent, of slope f_w K_lim, stands for it
// (and for ln J below, so that turned elements keep finite numbers). P is linear on the tetrahedra and follows Darcy's
// law on the rest shape, the fluid's compressibility being 1/K_lim:
//
//   P'/K_lim = kappa lap P - J'/J,     P = 0 at drainedIndices, no flow through the rest of the boundary
//   (M/K_lim + h kappa L) P^n = M P^{n-1}/K_lim - (theta^n - theta^{n-1}),   theta_a = sum_e V_e/4 ln J_e
//
// with the lumped volumes M of the nodes and L the gradients' products. The sum of M P/K_lim + theta over a body that
// is not drained does not change: the fluid is kept.
//
// coupling = semi_implicit, as published: forces see the pressure from before the step, and the pressure then follows
// the step's change of volume; time steps must be small where the fluid is stiff against the tissue, and the integrator
// one of first order, because a pressure that is a step late feeds oscillations. Statics have no mass to hold them: where
// K_lim is above the modulus of the drained tissue the pressure swings from step to step for ever. Such a run ends with a
// sentence and no result.
//
// implicit: forces see the pressure that belongs to their shape at the end of the step, whatever the step.
//
// tangent (of implicit coupling) = coupled eliminates the pressure, by the Schur complement of Darcy's matrix:
//
//   K = K_tissue - U^T (M/K_lim + h kappa L)^-1 U,   U = dtheta/dx with w^1/2 for w = d ln J/dJ
//
// exact where all elements have one J (else w is on one side of it; halves on both keep K symmetric): a few Newton
// iterations per step, whatever K_lim. A product solves with Darcy's matrix, factored once for all steps of one size. As
// a matrix K couples all nodes: bodies of more than 500 nodes assemble the undrained one instead, so take CGLinearSolver
// there. undrained: fluid that stays in each element; cheap, stable with one linear solve per step, and hundreds of
// Newton iterations where K_lim is large.
//
// Source: S. Marchesseau, T. Heimann, S. Chatelin, R. Willinger, H. Delingette, "Multiplicative Jacobian energy
// decomposition method for fast porous visco-hyperelastic soft tissue model", MICCAI 2010, section 3.2; the splits
// after D. Kim, H. A. Tchelepi, R. Juanes, "Stability, accuracy and efficiency of sequential methods for
// coupled flow and geomechanics", SPE J. 16 (2011) 249-262.
//
// Cell field for exporters: pressure (mean of a cell) [Pa]. The attribute pressure has it node by node.
//
// Example:
// <Node name="root" dt="0.02" gravity="0 0 -9.81">
//   <RegularGridTopology name="grid" n="3 3 5" min="0 0 0" max="0.02 0.02 0.05"/>
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-8"/>
//   <Node name="sponge">
//     <TetrahedronSetTopologyContainer name="tets"/>
//     <Hexa2TetraTopologicalMapping input="@../grid" output="@tets"/>
//     <MechanicalObject/>
//     <DiagonalMass massDensity="1000"/>
//     <TetrahedronHyperelasticityFEMForceField materialName="NeoHookean" youngModulus="2e3" poissonRatio="0.3"/>
//     <TetrahedronPorousForceField fluidFraction="0.5" bulkModulus="400" limitModulus="2200" permeability="1e-6"
//                                  drainedIndices="@top.indices"/>
//     <BoxROI name="held" box="-1 -1 -0.001 1 1 0.001"/>
//     <BoxROI name="top" box="-1 -1 0.0499 1 1 1"/>
//     <FixedProjectiveConstraint indices="@held.indices"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "components/hyperelasticity/darcy_flow.h"
#include "components/hyperelasticity/dense_coupling.h"
#include "components/hyperelasticity/porous_elements.h"
#include "components/hyperelasticity/pressure_swings.h"
#include "framework/mechanics/force_field.h"
#include "framework/mechanics/history.h"
#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

using porous::DenseCoupling;
using porous::PorousElements;
using porous::PorousFan;
using porous::Sponge;
using tetrahedron::corner;
using tetrahedron::fan_size;

/// A dense matrix of more nodes takes longer than the iterations that it saves, and gigabytes.
constexpr std::size_t most_dense_nodes = 500;

class TetrahedronPorousForceField final : public ForceField, public History {
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
  const std::vector<double>& history() const override { return pressure_; }

  double energy(ConstRows x) const override { return porous_ ? elements_->energy(x, now_) : 0; }
  void addForce(ConstRows x, ConstRows v, Rows f) override;
  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override;
  void addPattern(BlockPattern& pattern) const override;
  void prepareAssembly(const BlockMatrix& matrix) override;
  void addStiffness(double factor, BlockMatrix& matrix) const override;
  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override;
  Cost cost() const override {
    const double cells = double(mesh_->tetrahedra.size()), nodes = double(pressure_.size());
    if (!isCoupled()) return {8 * cells, 100 * cells};
    // without a dense matrix only products have the whole coupling
    return {8 * cells + 60 * nodes, dense_ ? 100 * cells + nodes * nodes * nodes : 1e30};
  }
  std::vector<std::string> cellFields() const override { return {"pressure"}; }
  void cellField(const std::string& name, ConstRows x, std::vector<double>& out) const override;

 private:
  enum class Coupling : int { semi_implicit, implicit };
  enum class Tangent : int { coupled, undrained };
  bool flows() const { return coupling_ == Coupling::implicit && step_ > 0; }
  bool isCoupled() const { return coupling_ == Coupling::implicit && tangent_ == Tangent::coupled; }
  void start(const std::vector<double>& values);
  /// out = P at the end of a step with volumes theta of nodes in `out`.
  void follow(Rows out) const;
  /// Up to date with the last force.
  DenseCoupling& dense() const;
  Rows own(Rows all) const { return {all.data + std::size_t(state().firstRow()) * row_doubles, state().size()}; }
  ConstRows systemRows() const {
    return {state().x().data - std::size_t(state().firstRow()) * row_doubles, state().firstRow() + state().size()};
  }

  TopologyLink topology_;
  bool porous_ = true;
  Sponge sponge_;
  double permeability_ = 0;
  std::vector<int> drained_;
  Coupling coupling_ = Coupling::semi_implicit;
  Tangent tangent_ = Tangent::coupled;
  std::vector<double> pressure_;  ///< at the end of the last step [Pa], shape (nodes)
  std::vector<double> initial_;

  const Mesh* mesh_ = nullptr;
  std::unique_ptr<PorousElements> elements_;
  mutable DarcyFlow flow_;
  std::unique_ptr<DenseCoupling> dense_;  ///< of implicit coupling, for bodies of few nodes
  mutable bool dense_ready_ = false;
  std::vector<Index> slots_, dense_slots_;
  double time_ = 0, step_ = 0;  ///< [s], of pressure_; from there to the time of the forces
  bool started_ = false;        ///< theta_ is known
  std::vector<double> theta_;   ///< at the end of the last step [m^3], shape (nodes)
  porous::PressureSwings swings_;
  Vector now_;             ///< pressures that the forces see, shape (system rows)
  mutable Vector change_;  ///< work space, shape (system rows)
};

void TetrahedronPorousForceField::declare(DataTable& table) {
  ForceField::declare(table);
  topology_.declare(table, "mesh that holds the tetrahedra");
  table.add("porous", porous_).help("false: no fluid and no force, to compare");
  table.add("fluidFraction", sponge_.fluid)
      .unit("-")
      .min(0, false)
      .max(1)
      .physical()
      .help("f_w: share of the volume at rest that is fluid and can leave");
  table.add("bulkModulus", sponge_.bulk)
      .unit("Pa")
      .min(0, false)
      .physical()
      .help("K_0 of the drained tissue, added to the elastic law's");
  table.add("limitModulus", sponge_.limit)
      .unit("Pa")
      .min(0, false)
      .physical()
      .help("K_lim: of the fluid, and bound of the tissue's when it is compressed; at least bulkModulus/fluidFraction");
  table.add("permeability", permeability_)
      .unit("m^4/(N s)")
      .min(0)
      .required()
      .help("kappa of Darcy's law; 0: nothing flows");
  table.add("drainedIndices", drained_).help("nodes with no pressure, where the fluid can leave; elsewhere none does");
  table.addChoice("coupling", coupling_, {"semi_implicit", "implicit"})
      .help("semi_implicit: forces see the pressure before the step; implicit: that of their own shape");
  table.addChoice("tangent", tangent_, {"coupled", "undrained"})
      .help("of implicit coupling: with the pressure that follows, or of fluid that stays in each element");
  table.add("pressure", pressure_).unit("Pa").help("of each node, at the start (zero when not given) and then now");
}

void TetrahedronPorousForceField::init() {
  ForceField::init();
  mesh_ = &topology_.meshWith(cell_kinds::tetrahedron, *this, state());
  if (!(sponge_.bulk <= sponge_.fluid * sponge_.limit))
    throw ComponentError(
        fmt::format("bulkModulus is {:g} and limitModulus {:g}", sponge_.bulk, sponge_.limit),
        fmt::format("limitModulus of at least bulkModulus/fluidFraction = {:g}", sponge_.bulk / sponge_.fluid));
  if (pressure_.empty()) pressure_.assign(state().size(), 0.);
  if (pressure_.size() != std::size_t(state().size()))
    throw ComponentError(fmt::format("pressure has {} values", pressure_.size()), fmt::format("{}", state().size()));
  std::vector<char> used(std::size_t(state().size()), 0);
  for (const Tetrahedron& cell : mesh_->tetrahedra)
    for (Index node : cell) used[node] = 1;
  const auto lonely = std::find(used.begin(), used.end(), 0);
  if (lonely != used.end())
    throw ComponentError(fmt::format("no tetrahedron has node {}: it holds no fluid", lonely - used.begin()),
                         "a mesh whose nodes are all used");
  initial_ = pressure_;
  std::vector<Index> drained;
  if (data().find("drainedIndices")->isSet()) drained = checkedNodes(drained_, state(), "drainedIndices");
  flow_.build(*mesh_, state().rest_position, drained);
}

ForceTraits TetrahedronPorousForceField::traits() const {
  ForceTraits t;
  t.has_stiffness = porous_;
  t.symmetric = t.torques_balance = t.time_dependent = true;
  t.forces_balance = std::all_of(initial_.begin(), initial_.end(), [](double p) { return p == 0; });
  t.conservative = t.exact_tangent = t.lagged = coupling_ == Coupling::semi_implicit;
  return t;
}

void TetrahedronPorousForceField::compile() {
  const std::vector<Vec3>& rest = state().rest_position;
  const auto fans = tetrahedron::gatherFans(mesh_->tetrahedra, rest.size());
  std::vector<std::array<Index, tetrahedron::fan_nodes>> nodes;
  nodes.reserve(fans.size());
  for (const auto& fan : fans) nodes.push_back(fan.nodes);
  StorageOf<PorousFan> storage;
  storage.build(nodes, rest, state().firstRow(), [&](std::size_t f, bool padding, auto& data, auto&) {
    for (int i = 0; i < fan_size; ++i) {
      const auto at = [&](int a) -> const Vec3& { return rest[nodes[f][(corner(i, a))]]; };
      Mat3 edges;
      edges << at(1) - at(0), at(2) - at(0), at(3) - at(0);
      const double six_volumes = edges.determinant(), volume = std::abs(six_volumes) / (6 * mesh_->overlap);
      const bool empty = padding || fans[f].element[i] < 0;
      data.of[i] = {empty ? 0 : std::copysign(1 / (6 * mesh_->overlap), six_volumes), 1 / six_volumes, 1 / volume,
                    empty ? 0 : volume / 4};
    }
  });
  elements_ = std::make_unique<PorousElements>(std::move(storage), sponge_);
  const Index rows = state().firstRow() + state().size();
  dense_.reset();
  if (isCoupled() && rest.size() <= most_dense_nodes)
    dense_ = std::make_unique<DenseCoupling>(*mesh_, rest, sponge_, state().firstRow());
  else if (isCoupled())
    inform(
        fmt::format("with more than {} nodes an assembled matrix keeps the fluid in each element, and Newton's method "
                    "may take many iterations with it: CGLinearSolver takes products, which have the whole coupling",
                    most_dense_nodes));
  now_.resize(rows), change_.resize(rows);
  theta_.resize(rest.size());
  start(initial_);
}

void TetrahedronPorousForceField::start(const std::vector<double>& values) {
  pressure_ = values;
  for (Index i = 0; i < state().size(); ++i) now_[state().firstRow() + i].x() = pressure_[i];
  time_ = node().root().root_time;
  step_ = 0;
  started_ = false;
  swings_.start(values.size());
}

void TetrahedronPorousForceField::serialize(Archive& archive) {
  archive.value("time", time_);
  archive.value("started", started_);
  archive.rows("pressure", pressure_.data(), pressure_.size());
  archive.rows("volumes", theta_.data(), theta_.size());
  swings_.serialize(archive);
  if (!archive.isReading()) return;
  for (Index i = 0; i < state().size(); ++i) now_[state().firstRow() + i].x() = pressure_[i];
  step_ = 0;
}

void TetrahedronPorousForceField::setTime(double t) {
  if (!porous_) return;
  if (!started_ && t > time_) {  // the first step: its positions are where it starts
    started_ = true;
    clear(change_);
    elements_->addVolumes(systemRows(), 1, change_);
    for (Index i = 0; i < state().size(); ++i) theta_[i] = own(change_)[i].x();
  }
  step_ = std::max(0., t - time_);
  if (step_ > 0) flow_.setStep(step_, 1 / sponge_.limit, permeability_);
}

void TetrahedronPorousForceField::follow(Rows out) const {
  for (Index i = 0; i < out.count; ++i) {
    double& value = out[i].x();
    value = flow_.volume(i) * pressure_[i] / sponge_.limit - (value - theta_[i]);
  }
  flow_.solve(out);
}

void TetrahedronPorousForceField::stepEnded(double t) {
  if (!porous_) return;
  setTime(t);
  clear(change_);
  elements_->addVolumes(systemRows(), 1, change_);
  const Rows values = own(change_);
  std::vector<double>& theta = theta_;
  for (Index i = 0; i < values.count; ++i) values[i].y() = values[i].x();  // kept for the next step
  follow(values);
  swings_.note(pressure_, values, 1e-10 * sponge_.limit);
  for (Index i = 0; i < values.count; ++i) {
    theta[i] = values[i].y();
    pressure_[i] = own(now_)[i].x() = values[i].x();
  }
  time_ = t;
  step_ = 0;
}

std::string TetrahedronPorousForceField::fault() const {
  constexpr long enough = 3;
  if (coupling_ == Coupling::implicit || swings_.inARow() < enough) return {};
  return fmt::format(
      "the fluid's pressure in {} swings from step to step and does not settle, for {} steps now: with limitModulus = "
      "{:g} Pa the fluid is stiffer than the tissue, which coupling=\"semi_implicit\" does not bear. "
      "coupling=\"implicit\" does",
      path(), swings_.inARow(), sponge_.limit);
}

void TetrahedronPorousForceField::addForce(ConstRows x, ConstRows, Rows f) {
  if (!porous_) return;
  dense_ready_ = false;
  if (flows()) {
    clear(now_);
    elements_->addVolumes({x.data, now_.count()}, 1, now_);
    follow(own(now_));
  }
  elements_->addForce(x, now_, {flows() && !isCoupled(), flows() && !dense_}, f);
}

void TetrahedronPorousForceField::addStiffnessProduct(ConstRows dx, double factor, Rows df) const {
  elements_->addProduct(dx, factor, df);
  if (!flows() || !isCoupled()) return;
  clear(change_);
  elements_->addVolumeChanges(dx, change_);
  flow_.solve(own(change_));
  elements_->addPressureForces(change_, -factor, df);
}

void TetrahedronPorousForceField::addPattern(BlockPattern& pattern) const {
  elements_->addPattern(pattern);
  if (dense_) dense_->addPattern(pattern);
}

void TetrahedronPorousForceField::prepareAssembly(const BlockMatrix& matrix) {
  slots_ = elements_->slots(matrix);
  if (dense_) dense_slots_ = dense_->slots(matrix);
}

DenseCoupling& TetrahedronPorousForceField::dense() const {
  if (!dense_ready_) dense_->update(elements_->positions(), flow_);
  dense_ready_ = true;
  return *dense_;
}

void TetrahedronPorousForceField::addStiffness(double factor, BlockMatrix& matrix) const {
  elements_->assemble(factor, slots_, matrix.values());
  if (flows() && dense_) dense().assemble(factor, dense_slots_.data(), matrix.values());
}

void TetrahedronPorousForceField::addStiffnessDiagonal(double factor, std::vector<double>& blocks) const {
  elements_->assembleDiagonal(factor, blocks);
  if (flows() && dense_) dense().assembleDiagonal(factor, blocks);
}

void TetrahedronPorousForceField::cellField(const std::string&, ConstRows, std::vector<double>& out) const {
  out.clear();
  for (const Tetrahedron& cell : mesh_->tetrahedra) {
    double pressure = 0;
    for (Index node : cell) pressure += pressure_[node] / 4;
    out.push_back(pressure);
  }
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(tetrahedron_porous_force_field) {
  factory.add<stroma::TetrahedronPorousForceField>("TetrahedronPorousForceField",
                                                   "fluid in a tissue: effective volume, Darcy's law, pressure");
}
