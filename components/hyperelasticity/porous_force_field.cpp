// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/hyperelasticity/porous_force_field.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "components/hyperelasticity/pressure_jumps.h"
#include "framework/algebra/linear_solver.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/archive.h"
#include "framework/scene/spans.h"

namespace stroma {
namespace {

/// A dense matrix of more nodes takes longer than the iterations that it saves, and gigabytes.
constexpr std::size_t most_dense_nodes = 500;
constexpr std::size_t few_dense_nodes = 60;

/// The nearest solver takes the system as a matrix and nothing else.
bool isFactored(const Node& body) {
  for (const Node* node = &body; node; node = node->parent())
    for (const auto& component : node->components())
      if (const auto* solver = dynamic_cast<const LinearSolver*>(component.get()))
        return !solver->data().find("iterations") && !solver->data().find("choice");
  return false;
}

}  // namespace

void PorousForceField::declare(DataTable& table) {
  ForceField::declare(table);
  topology_.declare(table, "mesh that holds the cells");
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
      .required()
      .help("K_0, that the drained tissue has besides the elastic law's; little against the tissue's where that has all of it");
  table.add("limitModulus", sponge_.limit)
      .unit("Pa")
      .min(0, false)
      .required()
      .help(
          "K_lim: of the fluid, and bound of the tissue's when it is compressed; at least bulkModulus/fluidFraction. Below the "
          "tissue's modulus the fluid carries next to nothing; 1000 times that, with coupling=\"implicit\", is as good as a fluid "
          "that is incompressible (water: 2.2e9)");
  declareModuli(table);
  table.add("permeability", permeability_)
      .unit("m^4/(N s)")
      .min(0)
      .required()
      .help("kappa of Darcy's law; 0: no flow");
  table.add("drainedIndices", drained_).help("nodes with no pressure, where the fluid can leave; elsewhere none does");
  table.addChoice("coupling", coupling_, {"semi_implicit", "implicit"})
      .help("semi_implicit: forces see the pressure before the step; implicit: that of their own shape");
  table.addChoice("tangent", tangent_, {"coupled", "undrained"})
      .help("of implicit coupling: with the pressure that follows, or of fluid that stays in each element");
  table.add("pressure", pressure_).unit("Pa").ofNodes().help("of each node, at the start (zero by default) and then now");
  table.add("fluidOfElements", fluid_of_elements_)
      .help("why an assembled matrix keeps the fluid in each element, where it does: integrators then solve for the flow by products")
      .output();
}

void PorousForceField::declareModuli(DataTable& table) {
  table.add("biotCoefficient", sponge_.coefficient)
      .unit("-")
      .min(0)
      .max(1)
      .help("alpha: share of the pressure that pushes the tissue; at least fluidFraction");
  table.add("biotModulus", sponge_.modulus)
      .unit("Pa")
      .min(0, false)
      .help("M, of the fluid's storage 1/M; limitModulus by default, which takes a biotCoefficient of 1");
  table.add("grainModulus", grain_modulus_)
      .unit("Pa")
      .min(0)
      .help("K_s of the solid material; with fluidModulus instead of biotModulus");
  table.add("fluidModulus", fluid_modulus_)
      .unit("Pa")
      .min(0)
      .help("K_f of the fluid: 1/M = (alpha - f_w)/K_s + f_w/K_f");
}

/// Which of the attributes give Biot's modulus.
void PorousForceField::chooseStorage() {
  if (sponge_.coefficient < sponge_.fluid)
    throw ComponentError(
        fmt::format("biotCoefficient is {:g} and fluidFraction {:g}", sponge_.coefficient, sponge_.fluid),
        "a biotCoefficient between fluidFraction and 1: pores push with at least their share of the volume");
  const bool grains = isSet("grainModulus"), fluid = isSet("fluidModulus");
  if (grains != fluid)
    throw ComponentError(
        fmt::format("{} needs {}", grains ? "grainModulus" : "fluidModulus", grains ? "fluidModulus" : "grainModulus"),
        "both, or biotModulus alone");
  if (grains && !(grain_modulus_ > 0 && fluid_modulus_ > 0))
    throw ComponentError(fmt::format("grainModulus is {:g} and fluidModulus {:g}", grain_modulus_, fluid_modulus_),
                         "numbers above 0");
  if (grains && isSet("biotModulus"))
    throw ComponentError("biotModulus, grainModulus and fluidModulus give the storage twice",
                         "biotModulus alone, or the other two");
  if (sponge_.coefficient < 1 && !grains && !isSet("biotModulus"))
    throw ComponentError(fmt::format("biotCoefficient is {:g}: grains that give way store fluid too, and how much is "
                                     "not given",
                                     sponge_.coefficient),
                         "biotModulus, or grainModulus and fluidModulus");
  if (grains)
    sponge_.modulus = 1 / ((sponge_.coefficient - sponge_.fluid) / grain_modulus_ + sponge_.fluid / fluid_modulus_);
  else if (!isSet("biotModulus"))
    sponge_.modulus = sponge_.limit;
}

void PorousForceField::checkCells() const {
  const std::string_view kind = cells_->kind().singular;
  for (std::size_t cell = 0; cell < cells_->count(); ++cell)
    if (const std::string fault = cells_->fault(cell); !fault.empty())
      throw ComponentError(fmt::format("{} {} (nodes {}) {}", kind, cell, fmt::join(cells_->nodes(cell), " "), fault),
                           "a cell with a volume");
  std::vector<char> used(std::size_t(state().size()), 0);
  for (std::size_t cell = 0; cell < cells_->count(); ++cell)
    for (Index node : cells_->nodes(cell)) used[node] = 1;
  const auto lonely = std::find(used.begin(), used.end(), 0);
  if (lonely != used.end())
    throw ComponentError(fmt::format("there is no {} with node {}: it contains no fluid", kind, lonely - used.begin()),
                         "a mesh whose nodes are all used");
}

void PorousForceField::init() {
  ForceField::init();
  cells_ =
      std::make_unique<porous::PorousCells>(kind(), topology_.meshWith(kind(), *this, state()), state().rest_position);
  if (!(sponge_.bulk <= sponge_.fluid * sponge_.limit))
    throw ComponentError(
        fmt::format("bulkModulus is {:g} and limitModulus {:g}", sponge_.bulk, sponge_.limit),
        fmt::format("limitModulus of at least bulkModulus/fluidFraction = {:g}", sponge_.bulk / sponge_.fluid));
  chooseStorage();
  if (pressure_.empty()) pressure_.assign(state().size(), 0.);
  if (pressure_.size() != std::size_t(state().size()))
    throw ComponentError(fmt::format("pressure has {} values", pressure_.size()), fmt::format("{}", state().size()));
  checkCells();
  if (initial_.empty()) initial_ = pressure_;  // made anew in a run, pressure_ is that of now
  std::vector<Index> drained;
  if (isSet("drainedIndices")) drained = checkedNodes(drained_, state(), "drainedIndices");
  flow_.build(*cells_, drained);
}

ForceField::Cost PorousForceField::cost() const {
  const double cells = double(cells_->count()), nodes = double(pressure_.size());
  const porous::PorousElements::Cost one = elements_->cost();
  if (!isCoupled()) return {one.product * cells, one.assembly * cells};
  // without a dense matrix only products have the whole coupling
  return {one.product * cells + 60 * nodes + flow_.solveCost(), dense_ ? one.assembly * cells + nodes * nodes * nodes : 1e30};
}

ForceTraits PorousForceField::traits() const {
  ForceTraits t;
  t.has_stiffness = porous_;
  t.symmetric = t.torques_balance = t.time_dependent = true;
  t.forces_balance = std::all_of(initial_.begin(), initial_.end(), [](double p) { return p == 0; });
  t.conservative = t.exact_tangent = t.lagged = coupling_ == Coupling::semi_implicit;
  return t;
}

void PorousForceField::compile() {
  const std::vector<Vec3>& rest = state().rest_position;
  elements_ = makeElements(*cells_, sponge_, state().firstRow());
  const Index rows = state().firstRow() + state().size();
  dense_.reset();
  if (isCoupled() && rest.size() <= most_dense_nodes)
    dense_ = std::make_unique<porous::DenseCoupling>(*cells_, sponge_, state().firstRow());
  if (dense_ && rest.size() > few_dense_nodes && isFactored(node()))
    inform(fmt::format("in an assembled matrix the pressure couples all {} nodes with each other: CGLinearSolver takes products, "
                       "which are faster", rest.size()));
  fluid_of_elements_.clear();
  if (isCoupled() && !dense_)
    fluid_of_elements_ = fmt::format("{} nodes, of more than {} a matrix that couples all takes too long", rest.size(), most_dense_nodes);
  if (!fluid_of_elements_.empty() && isFactored(node()))
    inform("an assembled matrix keeps the fluid in each element (" + fluid_of_elements_ +
           "): conjugate gradients with its factors solve for the flow. CGLinearSolver takes products alone");
  warnOfNoElasticity();
  now_.resize(rows), change_.resize(rows);
  theta_.resize(rest.size());
  start(initial_);
}

/// Fluid and its sponge resist changes of volume alone.
void PorousForceField::warnOfNoElasticity() const {
  std::vector<ForceField*> fields;
  node().root().collect(fields);
  const auto isOther = [this](const ForceField* field) { return field != this && field->traits().has_stiffness; };
  if (std::none_of(fields.begin(), fields.end(), isOther))
    warn("nothing here resists changes of shape: porous fields only resist changes of volume",
         "an elastic or hyperelastic force field of the same cells");
}

void PorousForceField::start(const std::vector<double>& values) {
  pressure_ = values;
  for (Index i = 0; i < state().size(); ++i) now_[state().firstRow() + i].x() = pressure_[i];
  time_ = node().root().root_time;
  step_ = 0;
  started_ = false;
  swings_.start(values.size());
}

void PorousForceField::serialize(Archive& archive) {
  archive.value("time", time_);
  archive.value("started", started_);
  archive.rows("pressure", pressure_.data(), pressure_.size());
  archive.rows("volumes", theta_.data(), theta_.size());
  swings_.serialize(archive);
  if (!archive.isReading()) return;
  for (Index i = 0; i < state().size(); ++i) now_[state().firstRow() + i].x() = pressure_[i];
  step_ = 0;
}

void PorousForceField::setTime(double t) {
  if (!porous_) return;
  if (!started_ && t > time_) {  // the first step: its positions are where it starts
    started_ = true;
    clear(change_);
    elements_->addVolumes(systemRows(), change_);
    for (Index i = 0; i < state().size(); ++i) theta_[i] = own(change_)[i].x();
  }
  step_ = std::max(0., t - time_);
  if (step_ > 0) flow_.setStep(step_, 1 / sponge_.modulus, permeability_);
}

void PorousForceField::follow(Rows out) const {
  for (Index i = 0; i < out.count; ++i) {
    double& value = out[i].x();
    value = flow_.volume(i) * pressure_[i] / sponge_.modulus - (value - theta_[i]);
  }
  flow_.solve(out);
}

void PorousForceField::stepEnded(double t) {
  if (!porous_) return;
  const Span span("remember", this);
  setTime(t);
  clear(change_);
  elements_->addVolumes(systemRows(), change_);
  const Rows values = own(change_);
  std::vector<double>& theta = theta_;
  for (Index i = 0; i < values.count; ++i) values[i].y() = values[i].x();  // kept for the next step
  follow(values);
  swings_.note(pressure_, values, 1e-10 * sponge_.modulus);
  for (Index i = 0; i < values.count; ++i) {
    theta[i] = values[i].y();
    pressure_[i] = own(now_)[i].x() = values[i].x();
  }
  time_ = t;
  step_ = 0;
}

std::string PorousForceField::fault() const {
  if (coupling_ == Coupling::implicit || swings_.inARow() < porous::PressureSwings::enough) return {};
  return fmt::format("the fluid's pressure in {} swings from step to step and does not settle, for {} steps now: {}", path(),
                     swings_.inARow(), whySwings());
}

/// In time bodies may swing and settle: what has swung is no motion of the tissue, and the run goes on.
std::string PorousForceField::doubt(ConstRows) const {
  if (!porous_) return {};
  if (coupling_ == Coupling::implicit || swings_.longest() < porous::PressureSwings::enough) return doubtOfJumps();
  return fmt::format("the fluid pressure has oscillated from step to step for {} consecutive steps, by {:.3g} Pa on average, which "
                     "is not a motion of the tissue: {}",
                     swings_.longest(), swings_.largest(), whySwings());
}

/// With permeability 0 nothing ever leaves.
std::string PorousForceField::doubtOfJumps() const {
  if (permeability_ == 0) return {};
  std::vector<char> drained(pressure_.size());
  for (std::size_t i = 0; i < drained.size(); ++i) drained[i] = flow_.isDrained(Index(i));
  const porous::PressureJump jump = porous::pressureJump(*cells_, pressure_, drained);
  if (jump.node < 0) return {};
  return fmt::format("the fluid pressure oscillates from node to node below the drained nodes of {}: {:.3g} Pa at node {}, {:.3g} "
                     "Pa at the next. The fluid has not left the first layer of cells yet, and nodal pressures are not valid; "
                     "shapes and cell means are. Use thinner cells at the drained surface or a larger dt: h^2/(4 permeability E) "
                     "for cells h thick and a tissue of modulus E",
                     path(), jump.here, jump.node, jump.beneath);
}

std::string PorousForceField::whySwings() const {
  return fmt::format("with {} = {:g} Pa the fluid is stiffer than the tissue, for which coupling=\"semi_implicit\" is unstable. Use "
                     "coupling=\"implicit\"",
                     sponge_.modulus == sponge_.limit ? "limitModulus" : "a Biot modulus", sponge_.modulus);
}

void PorousForceField::addForce(ConstRows x, ConstRows, Rows f) {
  if (!porous_) return;
  dense_ready_ = false;
  if (flows()) {
    clear(now_);
    elements_->addVolumes({x.data, now_.count()}, now_);
    follow(own(now_));
  }
  elements_->addForce(x, now_, {flows() && !isCoupled(), flows() && !dense_}, f);
}

void PorousForceField::addStiffnessProduct(ConstRows dx, double factor, Rows df) const {
  elements_->addProduct(dx, factor, df);
  if (!flows() || !isCoupled()) return;
  clear(change_);
  elements_->addVolumeChanges(dx, change_);
  flow_.solve(own(change_));
  elements_->addPressureForces(change_, -factor, df);
}

void PorousForceField::addPattern(BlockPattern& pattern) const {
  elements_->addPattern(pattern);
  if (dense_) dense_->addPattern(pattern);
}

void PorousForceField::prepareAssembly(const BlockMatrix& matrix) {
  slots_ = elements_->slots(matrix);
  if (dense_) dense_slots_ = dense_->slots(matrix);
}

porous::DenseCoupling& PorousForceField::dense() const {
  if (!dense_ready_) dense_->update(elements_->positions(), flow_);
  dense_ready_ = true;
  return *dense_;
}

void PorousForceField::addStiffness(double factor, BlockMatrix& matrix) const {
  elements_->assemble(factor, slots_, matrix.values());
  if (flows() && dense_) dense().assemble(factor, dense_slots_.data(), matrix.values());
}

void PorousForceField::addStiffnessDiagonal(double factor, std::vector<double>& blocks) const {
  elements_->assembleDiagonal(factor, blocks);
  if (flows() && dense_) dense().assembleDiagonal(factor, blocks);
}

void PorousForceField::cellField(const std::string&, ConstRows, std::vector<double>& out) const {
  out.clear();
  for (std::size_t cell = 0; cell < cells_->count(); ++cell) {
    const auto fraction = cells_->fractions(cell);
    double pressure = 0;
    std::size_t a = 0;
    for (Index node : cells_->nodes(cell)) pressure += pressure_[node] * fraction[a++];
    out.push_back(pressure);
  }
}

}  // namespace stroma
