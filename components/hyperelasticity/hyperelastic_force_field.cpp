// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/hyperelasticity/hyperelastic_force_field.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "components/hyperelasticity/hyperelastic_volume.h"
#include "components/hyperelasticity/point_kernels.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_lists.h"
#include "framework/scene/names.h"
#include "framework/scene/spans.h"

namespace stroma {

using hyperelastic::Form;
using hyperelastic::HyperelasticLaw;
using hyperelastic::hyperelasticLaws;
using hyperelastic::ParameterInfo;
using hyperelastic::residualStressKernels;
using hyperelastic::ViscousLaw;

void HyperelasticForceField::declare(DataTable& table) {
  declareMesh(table);
  declareLaw(table);
  declareMethod(table);
}

void HyperelasticForceField::declareMesh(DataTable& table) {
  ForceField::declare(table);
  topology_.declare(table, "mesh that holds the cells");
  table.add("template", template_).help("Vec3");
}

void HyperelasticForceField::declareLaw(DataTable& table) {
  std::set<std::string> names;
  for (const HyperelasticLaw& law : hyperelasticLaws()) names.insert(law.name);
  table.add("materialName", material_name_).physical().help(fmt::format("the law: {}", fmt::join(names, ", ")));
  table.add("ParameterSet", parameter_set_).recompiled().help("the law's parameters by position, instead of by name");
  table.add("youngModulus", young_modulus_)
      .recompiled()
      .unit("Pa")
      .min(0, false)
      .ofCells()
      .help("Young's modulus at small strains, for the parameters that are not given: one value, or one per cell");
  table.add("poissonRatio", poisson_ratio_)
      .recompiled()
      .unit("-")
      .min(-1, false)
      .max(0.5, false)
      .help("Poisson's ratio at small strains, with youngModulus");
  declareParameters(table);
  table.add("AnisotropyDirections", directions_)
      .unit("-")
      .ofCells()
      .help("fibre, or fibre and sheet (and normal): for all cells, or one after the other per cell or per node");
  table.add("considerInversion", consider_inversion_)
      .help("of SOFA's plugin: only false; what each law does with inverted elements is on its page");
  table.add("ParameterFile", parameter_file_).help("of SOFA's plugin: only empty; parameters take a value per cell");
}

void HyperelasticForceField::declareMethod(DataTable& table) {
  table.addChoice("discretization", discretization, {"mjed", "standard"})
      .help("mjed: derivatives by J and invariants; standard: the textbook's S and elasticity tensor, to compare");
  table.addChoice("dilatation", dilatation_, {"auto", "local", "mean"})
      .help(
          "of hexahedra and quadratic tetrahedra, the volume change that bulk stiffness meets: at each point, or one "
          "per cell: no locking; "
          "auto: "
          "one per cell where Poisson's ratio at small strains is 0.4 (of quadratic tetrahedra 0.45) or more");
  table.add("stiffInVolume", stiff_in_volume_)
      .help("why one linear solve per step is too few for this field; empty: it is not")
      .output();
  table.add("matrixRegularization", regularised_)
      .help("where J < 1 turn the tangent's part with d2W/dJ2 into a multiple of the identity (Marchesseau 2.3)");
  table.add("projectedTangent", projected_)
      .help(
          "set the negative eigenvalues of each point's tangent to zero: Newton directions are descent directions (except for viscosity)");
  prony_.declare(table);
}

/// One attribute for all laws with a parameter of that name; what it means to each, and its unit where they differ.
void HyperelasticForceField::declareParameters(DataTable& table) {
  std::map<std::string, std::map<std::string, std::set<std::string>>> laws_of;  // name, meaning, laws
  std::map<std::string, std::set<std::string>> units;
  std::vector<std::string> names;
  for (const HyperelasticLaw& law : hyperelasticLaws())
    for (const ParameterInfo& p : law.namedParameters()) {
      if (!units.count(p.name)) names.push_back(p.name);
      units[p.name].insert(p.unit);
    }
  for (const HyperelasticLaw& law : hyperelasticLaws())
    for (const ParameterInfo& p : law.namedParameters())
      laws_of[p.name][units[p.name].size() > 1 ? fmt::format("{} [{}]", p.help, p.unit) : p.help].insert(law.name);
  for (const std::string& name : names) {
    std::vector<std::string> meanings;
    for (const auto& [meaning, laws] : laws_of[name])
      meanings.push_back(fmt::format("{} ({})", meaning, fmt::join(laws, ", ")));
    Data& attribute = table.add(name, named_[name]).ofCells();
    attribute.help(fmt::format("{}: one value, or one per cell", fmt::join(meanings, "; ")));
    units[name].size() > 1 ? attribute.unitOrNumber("Pa") : attribute.unit(*units[name].begin());
  }
}

std::size_t HyperelasticForceField::cellCount() const {
  std::size_t count = 0;
  forEachCellList([&](const CellKind& of, const auto& cells) { count += of.type == kind->type ? cells.size() : 0; }, *mesh_);
  return count;
}

/// Nanoseconds as in ForceField::Cost.
HyperelasticForceField::KindKernels HyperelasticForceField::kernels() const {
  using hyperelastic::Cells;
  using Method = std::unique_ptr<ElementKernels>;
  if (kind->type == CellType::hexahedron)
    return {hyperelastic::pointKernels().hexahedra, hyperelastic::meanVolumeKernels().hexahedra,
            residualStressKernels().hexahedra, 120, 1200};
  if (kind->type == CellType::quadratic_tetrahedron)
    return {hyperelastic::pointKernels().quadratic_tetrahedra, hyperelastic::meanVolumeKernels().quadratic_tetrahedra,
            nullptr, 100, 2500};
  const auto tetrahedra = [](const HyperelasticLaw& law, const Cells& cells) -> Method {
    const bool is_own = cells.form == Form::mjed || cells.form == Form::regularised;
    return is_own ? law.tetrahedra(cells) : hyperelastic::pointKernels().tetrahedra(law, cells);
  };
  return {tetrahedra, nullptr, residualStressKernels().tetrahedra, 12, 85};
}

void HyperelasticForceField::init() {
  ForceField::init();
  refusePlugin();
  chooseMesh();
  chooseLaw();
  readParameters();
  readDirections();
  series_ = prony_.read(*this);
  if (series_.terms() > 0 && !kernels().held)
    throw ComponentError(fmt::format("viscosity has no kernels for {}", kind->plural), "tetrahedra");
  checkShapes();
  chooseDilatation();
  checkViscousPart();
  if (regularised_ && projected_)
    throw ComponentError("matrixRegularization and projectedTangent both replace the tangent", "one of them");
  if (regularised_ && !law_.curved_in_volume)
    throw ComponentError(
        fmt::format("matrixRegularization acts on d2W/dJ2 of the law, and the energy of {} has no J", law_.name),
        "projectedTangent=\"true\" for this law");
  const bool tetrahedra = kind->type == CellType::tetrahedron;
  if (!tetrahedra && regularised_)
    throw ComponentError("matrixRegularization exists for tetrahedra",
                         fmt::format("projectedTangent=\"true\" for {}", kind->plural));
  if (!tetrahedra && discretization == Discretization::standard)
    throw ComponentError("discretization standard, for comparison, exists for tetrahedra", "discretization=\"mjed\"");
  if (discretization == Discretization::standard && (regularised_ || projected_))
    throw ComponentError("discretization standard is the textbook's form, with its exact tangent",
                         "discretization=\"mjed\" with matrixRegularization or projectedTangent");
}

// Parameters may change while a scene runs: the mesh, its shapes and the axes stay.
void HyperelasticForceField::recompile() {
  chooseLaw();
  readParameters();
  chooseDilatation();
  checkViscousPart();
}

/// What SOFA's MJEDTetrahedralForceField has and this component has not.
void HyperelasticForceField::refusePlugin() const {
  if (consider_inversion_)
    throw ComponentError(
        "considerInversion, forces of an inverted element as if a node lay on the other side, is not available",
        "considerInversion=\"false\"", "StableNeoHookean, whose energy drives inverted elements back");
  if (!parameter_file_.empty())
    throw ComponentError(fmt::format("ParameterFile '{}' would not be read", parameter_file_),
                         "ParameterSet, or the parameters by name with one value per cell");
  if (material_name_ == "NeoHookeanIsotropic" || material_name_ == "Isotropic_NeoHookean")
    throw ComponentError(
        fmt::format("there is no law '{}'", material_name_),
        "NeoHookean, or with the isochoric invariant J^-2/3 I1 alone MooneyRivlin, c1 = mu/2, c2 = 0 and k0");
}

void HyperelasticForceField::chooseMesh() {
  if (!template_.empty() && template_.rfind("Vec3", 0) != 0)
    throw ComponentError(fmt::format("template '{}' is none that {} has", template_, type()), "Vec3");
  const Topology* topology = topology_.find(*this, state(), MeshNodes::first);
  if (!topology) throw ComponentError("there is no mesh", "a topology with cells in this node or above");
  mesh_ = &topology->mesh();
  if (cellCount() == 0)
    throw ComponentError(fmt::format("{} holds no {}", topology->path(), kind->plural),
                         fmt::format("a mesh of {}", kind->plural),
                         kind->type != CellType::tetrahedron || mesh_->hexahedra.empty()
                             ? ""
                             : "cut its hexahedra with Hexa2TetraTopologicalMapping, or "
                               "HexahedronHyperelasticityFEMForceField");
  const std::string problem = mesh_->firstError();
  if (!problem.empty()) throw ComponentError(problem);
}

ForceTraits HyperelasticForceField::traits() const {
  ForceTraits t;
  t.conservative = t.symmetric = t.forces_balance = t.torques_balance = true;
  t.exact_tangent = !regularised_ && !projected_;
  t.time_dependent = series_.terms() > 0;  // with its history held the stress has a potential
  return t;
}

hyperelastic::Values HyperelasticForceField::parametersIn(const std::vector<double>& values, std::size_t cell) const {
  const std::size_t count = law_.parameters.size();
  return {values.data() + (values.size() == count ? 0 : cell * count), count};
}
/// The parameters with k = 0.
std::vector<double> HyperelasticForceField::withoutVolume() const {
  std::vector<double> values = values_;
  for (std::size_t i = law_.volume_parameter; i < values.size(); i += law_.parameters.size()) values[i] = 0;
  return values;
}
Mat3 HyperelasticForceField::axes(std::size_t cell) const { return axes_.size() == 1 ? axes_[0] : axes_[cell]; }

hyperelastic::Cells HyperelasticForceField::cells() const {
  const Form form = discretization == Discretization::standard ? Form::standard
                    : regularised_                             ? Form::regularised
                    : projected_ || definite_                  ? Form::projected
                                                               : Form::mjed;
  return {mesh_,
          &state().rest_position,
          state().firstRow(),
          [this](std::size_t cell) { return parameters(cell); },
          [this](std::size_t cell) { return axes(cell); },
          form};
}

void HyperelasticForceField::compile() {
  if (definite_) std::swap(method_, other_method_);
  definite_ = false;
  other_method_.reset();
  if (volumeIsApart()) local_values_ = withoutVolume();
  const Made now{state().firstRow(), mean_dilatation_, law_.parameters.size()};
  const bool is_alike = method_ && now == made_;
  made_ = now;
  if (is_alike && method_->refill()) {
    if (viscous_) reset();
    return;
  }
  if (series_.terms() == 0) {
    method_ = makeElastic();
    return;
  }
  const auto make = [this](const hyperelastic::Cells& of) { return kernels().make(law_, of); };
  const hyperelastic::Cells own = elasticCells();
  method_ = make(own);
  const bool mean = mean_dilatation_;
  makeViscous(own, volumeIsApart() && !mean ? make(cells()) : nullptr);
  if (mean)
    method_ = std::make_unique<hyperelastic::SumOfKernels>(std::move(method_), kernels().mean_volume(cells(), law_, false));
}

/// Without what volumeIsApart() puts aside.
hyperelastic::Cells HyperelasticForceField::elasticCells() const {
  hyperelastic::Cells own = cells();
  if (volumeIsApart()) own.parameters = [this](std::size_t cell) { return parametersIn(local_values_, cell); };
  return own;
}

std::unique_ptr<ElementKernels> HyperelasticForceField::makeElastic() const {
  const KindKernels of = kernels();
  std::unique_ptr<ElementKernels> method = of.make(law_, elasticCells());
  if (!mean_dilatation_) return method;
  return std::make_unique<hyperelastic::SumOfKernels>(std::move(method), of.mean_volume(cells(), law_, definite_));
}

/// Elements of both lie in one order: what was looked up for the one serves the other.
bool HyperelasticForceField::useDefiniteTangent(bool definite) {
  const bool has_other = series_.terms() == 0 && !regularised_ && !projected_ && discretization == Discretization::mjed;
  if (!has_other || definite_ == definite) return has_other;
  definite_ = definite;
  if (!other_method_) other_method_ = makeElastic();
  std::swap(method_, other_method_);
  return true;
}

// ---- viscosity ----

/// method_, that of `own`, relaxes; `whole` is the law of which it is a part, or null.
void HyperelasticForceField::makeViscous(const hyperelastic::Cells& own, std::unique_ptr<ElementKernels> whole) {
  auto viscous = std::make_unique<ViscousLaw>(std::move(method_), std::move(whole), law_, own, cellCount(), series_,
                                              kernels().held(own), node().root().root_time);
  viscous_ = viscous.get();
  method_ = std::move(viscous);
  reset();
}
/// The system's rows up to the last of the state.
ConstRows HyperelasticForceField::systemRows() const {
  const Index first = state().firstRow();
  return {state().x().data - std::size_t(first) * row_doubles, first + state().size()};
}
void HyperelasticForceField::setTime(double t) {
  if (viscous_) viscous_->setTime(t, systemRows());
}
void HyperelasticForceField::stepEnded(double t) {
  if (!viscous_) return;
  const Span span("remember", this);
  viscous_->stepEnded(t, systemRows());
}
void HyperelasticForceField::reset() {
  fault_.clear();
  if (viscous_) viscous_->start(node().root().root_time);
}
const std::vector<double>& HyperelasticForceField::history() const {
  static const std::vector<double> none;
  return viscous_ ? viscous_->history() : none;
}
void HyperelasticForceField::serialize(Archive& archive) {
  if (viscous_) viscous_->serialize(archive);
}

// ---- forces ----

void HyperelasticForceField::addForce(ConstRows x, ConstRows v, Rows f) {
  ElementKernelsField::addForce(x, v, f);
  checkFinite(x, f);
}
void HyperelasticForceField::addForceAndProduct(ConstRows x, ConstRows v, ConstRows dx, double factor, Rows f) {
  ElementKernelsField::addForceAndProduct(x, v, dx, factor, f);
  checkFinite(x, f);
}

/// A law that is infinite at J = 0 makes NaN of a flat element: remembers which it was, for the report, until the next
/// force that is finite or whose elements all have a volume (then another component's is not). Positions that are not
/// finite themselves are the consequence: the cause is kept. One sum a force.
void HyperelasticForceField::checkFinite(ConstRows x, ConstRows f) {
  if (!law_.infinite_at_zero) return;
  double sum = 0;
  const ConstRows own = ownRows(f);
  for (std::size_t i = 0; i < own.doubles(); ++i) sum += own.data[i] * 0;
  if (sum == 0) {
    fault_.clear();
    return;
  }
  double j = 0;
  const std::size_t cell = worstCell(ownRows(x), j);
  if (j <= 0)
    fault_ = fmt::format("{} had J = {:.3g}, where the energy of {} is infinite", describe(cell), j, law_.name);
  else if (j > 0)
    fault_.clear();
}

ForceField::Cost HyperelasticForceField::cost() const {
  const double cells = double(cellCount());
  return {cells * kernels().product, cells * kernels().assembly};
}

ConstRows HyperelasticForceField::ownRows(ConstRows x) const {
  return {x.data + std::size_t(state().firstRow()) * row_doubles, state().size()};
}

}  // namespace stroma
