// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/fem/hyperelastic_force_field.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "framework/scene/names.h"

namespace stroma {

using hyperelastic::Form;
using hyperelastic::heldStressKernels;
using hyperelastic::HyperelasticLaw;
using hyperelastic::hyperelasticLaws;
using hyperelastic::ParameterInfo;
using hyperelastic::ViscousLaw;

namespace {

constexpr double not_given = std::numeric_limits<double>::quiet_NaN();

double at(const std::vector<double>& values, std::size_t cell) { return values.size() == 1 ? values[0] : values[cell]; }

/// Gradients of shape functions (columns, in the order of the cell) at the integration points.
using Gradients = Eigen::Matrix<double, 3, Eigen::Dynamic>;
std::vector<Gradients> gradientsOf(const std::vector<Vec3>& corner) {
  std::vector<Gradients> result;
  if (corner.size() == 4) {
    Mat3 edges;
    edges << corner[1] - corner[0], corner[2] - corner[0], corner[3] - corner[0];
    const Mat3 g = edges.inverse().transpose();
    Gradients all(3, 4);
    all << -g.rowwise().sum(), g;
    return {all};
  }
  constexpr int sign[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                              {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
  for (int p = 0; p < 8; ++p) {
    const double g = 1 / std::sqrt(3.), s[3] = {p & 1 ? g : -g, p & 2 ? g : -g, p & 4 ? g : -g};
    Gradients local(3, 8);
    for (int a = 0; a < 8; ++a)
      for (int i = 0; i < 3; ++i) {
        double value = sign[a][i] / 8.;
        for (int k = 0; k < 3; ++k)
          if (k != i) value *= 1 + sign[a][k] * s[k];
        local(i, a) = value;
      }
    Mat3 j = Mat3::Zero();
    for (int a = 0; a < 8; ++a) j += corner[std::size_t(a)] * local.col(a).transpose();
    result.push_back(j.inverse().transpose() * local);
  }
  return result;
}

template <class Nodes, class Position>
std::vector<Vec3> cornersOf(const Nodes& nodes, Position&& position) {
  std::vector<Vec3> corner;
  for (Index n : nodes) corner.push_back(position(n));
  return corner;
}

struct Moduli {
  double shear, bulk;
};
/// Of small strains [Pa], across a fibre, by central differences of the stress: dP of the shear e2 (x) e3 + e3 (x) e2
/// is 2 mu times it, of the dilation Id 3 K times it; neither stretches the fibre e1 at constant volume. Relative error
/// 1e-7.
Moduli moduliAtRest(const HyperelasticLaw& law, const double* values) {
  constexpr double h = 1e-4;
  const Mat3 unit = Mat3::Identity();
  Mat3 shear = Mat3::Zero();
  shear(1, 2) = shear(2, 1) = 1;
  const auto change = [&](const Mat3& df) -> Mat3 {
    return (law.stress(values, unit + h * df) - law.stress(values, unit - h * df)) / (2 * h);
  };
  return {change(shear)(1, 2) / 2, change(unit).trace() / 9};
}

/// Whether a shape and its mirror image have the same stress: an energy of C alone, without J.
bool isMirrored(const HyperelasticLaw& law, const double* values) {
  Mat3 f;
  f << 1.1, 0.2, -0.1, 0.05, 0.9, 0.3, 0.1, -0.2, 1.2;
  const Mat3 p = law.stress(values, f);
  return (law.stress(values, -f) + p).norm() < 1e-10 * p.norm();
}

}  // namespace

void HyperelasticForceField::declare(DataTable& table) {
  ForceField::declare(table);
  std::set<std::string> names;
  for (const HyperelasticLaw& law : hyperelasticLaws()) names.insert(law.name);
  table.addLink("topology", topology_)
      .help("mesh that holds the cells; the node's own (or the nearest above) when not given");
  table.add("template", template_).help("Vec3");
  table.add("materialName", material_name_).physical().help(fmt::format("the law: {}", fmt::join(names, ", ")));
  table.add("ParameterSet", parameter_set_).help("the law's parameters by position, instead of by name");
  table.add("youngModulus", young_modulus_)
      .unit("Pa")
      .min(0, false)
      .help("Young's modulus at small strains, for the parameters that are not given: one value, or one a cell");
  table.add("poissonRatio", poisson_ratio_)
      .unit("-")
      .min(-1, false)
      .max(0.5, false)
      .help("Poisson's ratio at small strains, with youngModulus");
  for (const HyperelasticLaw& law : hyperelasticLaws())
    for (const ParameterInfo& p : law.parameters) {
      if (named_.count(p.name)) continue;
      std::set<std::string> users;
      for (const HyperelasticLaw& other : hyperelasticLaws())
        for (const ParameterInfo& o : other.parameters)
          if (o.name == p.name) users.insert(other.name);
      table.add(p.name, named_[p.name])
          .unit(p.unit)
          .help(fmt::format("{} ({}): one value, or one a cell", p.help, fmt::join(users, ", ")));
    }
  table.add("AnisotropyDirections", directions_)
      .help("fibre, or fibre and sheet (and normal): for all cells, or one after the other for each cell");
  table.addChoice("discretization", discretization, {"mjed", "standard"})
      .help("mjed: derivatives by J and invariants; standard: the textbook's S and elasticity tensor, to compare");
  table.add("matrixRegularization", regularised_)
      .help("where J < 1 turn the tangent's part with d2W/dJ2 into a multiple of the identity (Marchesseau 2.3)");
  table.add("projectedTangent", projected_)
      .help(
          "set the unstable eigenvalues of each point's tangent to zero: every step of Newton goes downhill (but for "
          "what "
          "viscosity adds)");
  table.add("considerInversion", consider_inversion_)
      .help("of SOFA's plugin: only false; what each law does with inverted elements is on its page");
  table.add("ParameterFile", parameter_file_).help("of SOFA's plugin: only empty; parameters take a value a cell");
  prony_.declare(table);
  history_file_.declare(table);
}

std::size_t HyperelasticForceField::cellCount() const {
  return hexahedra ? mesh_->hexahedra.size() : mesh_->tetrahedra.size();
}

void HyperelasticForceField::init() {
  ForceField::init();
  refusePlugin();
  chooseMesh();
  chooseLaw();
  readParameters();
  readDirections();
  series_ = prony_.read(*this);
  if (series_.terms() > 0 && !(hexahedra ? heldStressKernels().hexahedra : heldStressKernels().tetrahedra))
    throw ComponentError("viscosity has no kernels for these cells", "tetrahedra");
  if (series_.terms() == 0 && history_file_.isGiven())
    throw ComponentError("a history is given, and without viscosity nothing is remembered", "viscous=\"true\"");
  checkShapes();
  if (regularised_ && projected_)
    throw ComponentError("matrixRegularization and projectedTangent both replace the tangent", "one of them");
  if (regularised_ && isMirrored(*law_, parameters(0)))
    throw ComponentError(
        fmt::format("matrixRegularization acts on d2W/dJ2 of the law, and the energy of {} has no J", law_->name),
        "projectedTangent=\"true\" for this law");
  if (hexahedra && regularised_)
    throw ComponentError("matrixRegularization exists for tetrahedra", "projectedTangent=\"true\" for hexahedra");
  if (hexahedra && discretization == Discretization::standard)
    throw ComponentError("discretization standard, for comparison, exists for tetrahedra", "discretization=\"mjed\"");
  if (discretization == Discretization::standard && (regularised_ || projected_))
    throw ComponentError("discretization standard is the textbook's form, with its exact tangent",
                         "discretization=\"mjed\" with matrixRegularization or projectedTangent");
}

/// What SOFA's MJEDTetrahedralForceField has and this component has not.
void HyperelasticForceField::refusePlugin() const {
  if (consider_inversion_)
    throw ComponentError(
        "considerInversion, forces of an inverted element as if a node lay on the other side, is not available",
        "considerInversion=\"false\"", "StableNeoHookean, whose energy drives inverted elements back");
  if (!parameter_file_.empty())
    throw ComponentError(fmt::format("ParameterFile '{}' would not be read", parameter_file_),
                         "ParameterSet, or the parameters by name with one value a cell");
  if (material_name_ == "NeoHookeanIsotropic" || material_name_ == "Isotropic_NeoHookean")
    throw ComponentError(
        fmt::format("there is no law '{}'", material_name_),
        "NeoHookean, or with the isochoric invariant J^-2/3 I1 alone MooneyRivlin, c1 = mu/2, c2 = 0 and k0");
}

void HyperelasticForceField::chooseMesh() {
  if (!template_.empty() && template_.rfind("Vec3", 0) != 0)
    throw ComponentError(fmt::format("template '{}' is none that {} has", template_, type()), "Vec3");
  const Topology* topology = topology_.target() ? topology_.get() : find<Topology>(true);
  if (!topology) throw ComponentError("there is no mesh", "a topology with cells in this node or above");
  mesh_ = &topology->mesh();
  if (cellCount() == 0)
    throw ComponentError(fmt::format("{} holds no {}", topology->path(), hexahedra ? "hexahedra" : "tetrahedra"),
                         fmt::format("a mesh of {}", hexahedra ? "hexahedra" : "tetrahedra"),
                         hexahedra || mesh_->hexahedra.empty()
                             ? ""
                             : "cut its hexahedra with Hexa2TetraTopologicalMapping, or "
                               "HexahedronHyperelasticityFEMForceField");
  const std::string problem = mesh_->firstError();
  if (!problem.empty()) throw ComponentError(problem);
  if (mesh_->nodes() > state().size())
    throw ComponentError(
        fmt::format("the mesh has {} nodes, {} has {}", mesh_->nodes(), state().path(), state().size()),
        "the same number");
}

std::vector<std::string> HyperelasticForceField::givenNames() const {
  std::vector<std::string> given;
  for (const auto& [name, values] : named_)
    if (!values.empty()) given.push_back(name);
  return given;
}

// The law with this name that the given parameters fit: more terms, more parameters.
void HyperelasticForceField::chooseLaw() {
  std::vector<const HyperelasticLaw*> candidates;
  std::vector<std::string> names;
  for (const HyperelasticLaw& law : hyperelasticLaws()) {
    names.push_back(law.name);
    if (law.name == material_name_) candidates.push_back(&law);
  }
  if (candidates.empty())
    throw ComponentError(fmt::format("there is no law '{}'", material_name_),
                         fmt::format("{}", fmt::join(std::set<std::string>(names.begin(), names.end()), ", ")),
                         nearest(material_name_, names));
  std::vector<std::string> expected;
  for (const HyperelasticLaw* law : candidates) expected.push_back(law->expectation());
  const std::vector<std::string> given = givenNames();
  if (!parameter_set_.empty() && (!given.empty() || !young_modulus_.empty() || !poisson_ratio_.empty()))
    throw ComponentError("parameters are given by position and by name", "ParameterSet or names");
  for (const HyperelasticLaw* law : candidates) {
    const auto has = [&](const std::string& name) {
      return std::any_of(law->parameters.begin(), law->parameters.end(), [&](const auto& p) { return p.name == name; });
    };
    const bool fits = parameter_set_.empty() ? std::all_of(given.begin(), given.end(), has)
                                             : parameter_set_.size() == law->parameters.size();
    if (fits) {
      law_ = law;
      return;
    }
  }
  if (!parameter_set_.empty())
    throw ComponentError(fmt::format("ParameterSet of {} has {} values", material_name_, parameter_set_.size()),
                         fmt::format("{}", fmt::join(expected, ", or ")));
  throw ComponentError(fmt::format("{} does not take {}", material_name_, fmt::join(given, ", ")),
                       fmt::format("{}", fmt::join(expected, ", or ")));
}

/// Set `set` of parameters from names and from E and nu.
void HyperelasticForceField::fillNamed(std::size_t set, std::vector<double>& values) const {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto& given = named_.at(law_->parameters[i].name);
    values[i] = given.empty() ? not_given : at(given, set);
  }
  const bool complete = std::none_of(values.begin(), values.end(), [](double v) { return std::isnan(v); });
  if (young_modulus_.empty() != poisson_ratio_.empty())
    throw ComponentError("youngModulus and poissonRatio make sense together", "both");
  if (!young_modulus_.empty()) {
    if (!law_->from_lame)
      throw ComponentError(fmt::format("{} cannot be given by youngModulus and poissonRatio", law_->name),
                           law_->expectation());
    if (complete)
      throw ComponentError(fmt::format("{} has all its parameters besides youngModulus", law_->name),
                           "one or the other");
    const Lame lame = Lame::from(at(young_modulus_, set), at(poisson_ratio_, set));
    const std::string missing = law_->from_lame(lame, values);
    if (!missing.empty()) throw ComponentError(missing, law_->expectation());
    checkModuli(lame, values.data());
  }
  std::vector<std::string> absent;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::isnan(values[i])) absent.push_back(law_->parameters[i].name);
  if (!absent.empty())
    throw ComponentError(fmt::format("{} needs {}", law_->name, fmt::join(absent, ", ")),
                         law_->expectation() + (law_->from_lame ? ", or youngModulus and poissonRatio" : ""));
}

/// Refuses parameters that contradict E and nu, beyond the figures that people write.
void HyperelasticForceField::checkModuli(const Lame& lame, const double* values) const {
  const auto [shear, bulk] = moduliAtRest(*law_, values);
  const double bulk_asked = lame.lambda + 2. / 3 * lame.mu;
  const auto agree = [](double a, double b) { return std::abs(a - b) <= 1e-3 * std::abs(b); };
  if (agree(shear, lame.mu) && agree(bulk, bulk_asked)) return;
  throw ComponentError(
      fmt::format("youngModulus and poissonRatio mean a shear modulus of {:.6g} Pa and a bulk modulus of {:.6g} Pa; "
                  "with {} of {} they are {:.6g} and {:.6g}",
                  lame.mu, bulk_asked, fmt::join(givenNames(), ", "), law_->name, shear, bulk),
      "parameters that agree, or youngModulus and poissonRatio alone for them");
}

void HyperelasticForceField::readParameters() {
  const std::size_t count = law_->parameters.size();
  std::size_t sets = 1;
  const auto check = [&](const std::string& name, const std::vector<double>& values) {
    if (values.size() <= 1) return;
    if (values.size() != cellCount())
      throw ComponentError(fmt::format("{} has {} values", name, values.size()),
                           fmt::format("1, or {} (one a cell)", cellCount()));
    sets = cellCount();
  };
  check("youngModulus", young_modulus_), check("poissonRatio", poisson_ratio_);
  for (const auto& [name, values] : named_) check(name, values);
  values_.clear();
  for (std::size_t set = 0; set < sets; ++set) {
    std::vector<double> values = parameter_set_;
    if (values.empty()) values.resize(count), fillNamed(set, values);
    for (std::size_t i = 0; i < count; ++i)
      if (law_->parameters[i].positive && !(values[i] > 0))
        throw ComponentError(fmt::format("{} of {} is {}", law_->parameters[i].name, law_->name, values[i]),
                             "a value above 0");
    const std::string problem = law_->check ? law_->check(values.data()) : "";
    if (!problem.empty()) throw ComponentError(problem, law_->expectation());
    values_.insert(values_.end(), values.begin(), values.end());
  }
}

void HyperelasticForceField::readDirections() {
  axes_ = {Mat3::Identity()};
  if (law_->directions == 0) {
    if (!directions_.empty())
      throw ComponentError(fmt::format("{} is isotropic", law_->name), "no AnisotropyDirections",
                           "Costa or TransverselyIsotropic");
    return;
  }
  const std::size_t n = directions_.size(), cells = cellCount();
  const bool frames = law_->directions == 3;
  const std::string expected =
      frames ? fmt::format("2 or 3 (fibre, sheet, normal), or {} or {} (for each cell)", 2 * cells, 3 * cells)
             : fmt::format("1, or {} (one a cell)", cells);
  std::size_t each = 0;
  for (std::size_t k : frames ? std::vector<std::size_t>{2, 3} : std::vector<std::size_t>{1})
    if (n == k || n == k * cells) each = k;
  if (each == 0)
    throw ComponentError(fmt::format("AnisotropyDirections of {} has {} vectors", law_->name, n), expected,
                         frames && n == 0 ? "AnisotropyDirections=\"1 0 0  0 1 0\" for axes x, y, z" : "");
  axes_.assign(n / each, Mat3::Identity());
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const Vec3 fibre = directions_[i * each];
    Vec3 other = Vec3::Unit(0);
    for (int k = 1; k < 3; ++k)  // without a sheet: any
      if (std::abs(fibre[k]) < std::abs(fibre.dot(other))) other = Vec3::Unit(k);
    const Vec3 sheet = each > 1 ? directions_[i * each + 1] : other, normal = fibre.cross(sheet);
    if (!(normal.norm() > 1e-6 * fibre.norm() * sheet.norm()))
      throw ComponentError(fmt::format("AnisotropyDirections {} has no length or no sheet direction", i),
                           "vectors that are not zero and not parallel");
    axes_[i].col(0) = fibre.normalized(), axes_[i].col(2) = normal.normalized();
    axes_[i].col(1) = axes_[i].col(2).cross(axes_[i].col(0));
  }
}

void HyperelasticForceField::checkShapes() const {
  for (std::size_t cell = 0; cell < cellCount(); ++cell) {
    const auto rest = [&](Index n) -> Vec3 { return state().rest_position[std::size_t(n)]; };
    const std::vector<Vec3> corner =
        hexahedra ? cornersOf(mesh_->hexahedra[cell], rest) : cornersOf(mesh_->tetrahedra[cell], rest);
    double longest = 0;
    for (const Vec3& c : corner) longest = std::max(longest, (c - corner[0]).norm());
    for (const Gradients& g : gradientsOf(corner)) {
      Mat3 f = Mat3::Zero();
      for (std::size_t a = 0; a < corner.size(); ++a) f += corner[a] * g.col(Eigen::Index(a)).transpose();
      if (!(g.norm() < 1e12 / longest) || !(std::abs(f.trace() - 3) < 1e-3))
        throw ComponentError(describe(cell) + " is flat at rest", "a volume");
    }
  }
}

ForceTraits HyperelasticForceField::traits() const {
  ForceTraits t;
  t.conservative = t.symmetric = t.forces_balance = t.torques_balance = true;
  t.exact_tangent = !regularised_ && !projected_;
  t.time_dependent = series_.terms() > 0;  // with its history held the stress has a potential
  return t;
}

const double* HyperelasticForceField::parameters(std::size_t cell) const {
  const std::size_t count = law_->parameters.size();
  return values_.data() + (values_.size() == count ? 0 : cell * count);
}
Mat3 HyperelasticForceField::axes(std::size_t cell) const { return axes_.size() == 1 ? axes_[0] : axes_[cell]; }

hyperelastic::Cells HyperelasticForceField::cells() const {
  const Form form = discretization == Discretization::standard ? Form::standard
                    : regularised_                             ? Form::regularised
                    : projected_                               ? Form::projected
                                                               : Form::mjed;
  return {mesh_,
          &state().rest_position,
          state().firstRow(),
          [this](std::size_t cell) { return parameters(cell); },
          [this](std::size_t cell) { return axes(cell); },
          form};
}

void HyperelasticForceField::compile() {
  method_ = (hexahedra ? law_->hexahedra : law_->tetrahedra)(cells());
  if (series_.terms() > 0) makeViscous();
}

// ---- viscosity ----

void HyperelasticForceField::makeViscous() {
  const auto held = hexahedra ? heldStressKernels().hexahedra : heldStressKernels().tetrahedra;
  auto viscous = std::make_unique<ViscousLaw>(std::move(method_), *law_, cells(), cellCount(), series_, held(cells()),
                                              node().root().root_time);
  viscous_ = viscous.get();
  method_ = std::move(viscous);
  initial_history_ = history_file_.read();
  const std::size_t expected = viscous_->history().size();
  if (history_file_.isGiven() && initial_history_.size() != expected)
    throw ComponentError(fmt::format("the history has {} numbers", initial_history_.size()),
                         fmt::format("{}: that of a run with this mesh and this series", expected));
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
  if (viscous_) viscous_->stepEnded(t, systemRows());
}
void HyperelasticForceField::reset() {
  fault_.clear();
  if (viscous_) viscous_->start(node().root().root_time, initial_history_);
}
const std::vector<double>& HyperelasticForceField::history() const {
  static const std::vector<double> none;
  return viscous_ ? viscous_->history() : none;
}
void HyperelasticForceField::setHistory(const std::vector<double>& values) {
  if (viscous_) viscous_->start(node().root().root_time, values);
}

// ---- forces ----

void HyperelasticForceField::addForce(ConstRows x, ConstRows v, Rows f) {
  ElementMethodField::addForce(x, v, f);
  checkFinite(x, f);
}
void HyperelasticForceField::addForceAndProduct(ConstRows x, ConstRows v, ConstRows dx, double factor, Rows f) {
  ElementMethodField::addForceAndProduct(x, v, dx, factor, f);
  checkFinite(x, f);
}

/// A law that is infinite at J = 0 makes NaN of a flat element: remembers which it was, for the report, until the next
/// force that is finite or whose elements all have a volume (then another component's is not). Positions that are not
/// finite themselves are the consequence: the cause is kept. One sum a force.
void HyperelasticForceField::checkFinite(ConstRows x, ConstRows f) {
  if (!law_->infinite_at_zero) return;
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
    fault_ = fmt::format("{} had J = {:.3g}, where the energy of {} is infinite", describe(cell), j, law_->name);
  else if (j > 0)
    fault_.clear();
}

ForceField::Cost HyperelasticForceField::cost() const {
  const double cells = double(cellCount());
  return {cells * (hexahedra ? 120 : 12), cells * (hexahedra ? 1200 : 150)};
}

ConstRows HyperelasticForceField::ownRows(ConstRows x) const {
  return {x.data + std::size_t(state().firstRow()) * row_doubles, state().size()};
}

std::string HyperelasticForceField::describe(std::size_t cell) const {
  return hexahedra ? fmt::format("hexahedron {} (nodes {})", cell, fmt::join(mesh_->hexahedra[cell], " "))
                   : fmt::format("tetrahedron {} (nodes {})", cell, fmt::join(mesh_->tetrahedra[cell], " "));
}

std::vector<Mat3> HyperelasticForceField::deformations(std::size_t cell, ConstRows x) const {
  const auto rest = [&](Index n) -> Vec3 { return state().rest_position[std::size_t(n)]; };
  const auto now = [&](Index n) -> Vec3 { return x[n]; };
  const auto both = [&](const auto& nodes) {
    const std::vector<Vec3> corner = cornersOf(nodes, now);
    std::vector<Mat3> result;
    for (const Gradients& g : gradientsOf(cornersOf(nodes, rest))) {
      result.push_back(Mat3::Zero());
      for (std::size_t a = 0; a < corner.size(); ++a) result.back() += corner[a] * g.col(Eigen::Index(a)).transpose();
    }
    return result;
  };
  return hexahedra ? both(mesh_->hexahedra[cell]) : both(mesh_->tetrahedra[cell]);
}

double HyperelasticForceField::smallestJacobian(std::size_t cell, ConstRows x) const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Mat3& f : deformations(cell, x)) {
    const double j = f.determinant();
    if (!(j >= smallest)) smallest = j;
  }
  return smallest;
}

std::size_t HyperelasticForceField::worstCell(ConstRows x, double& jacobian) const {
  jacobian = std::numeric_limits<double>::infinity();
  std::size_t worst = 0;
  for (std::size_t cell = 0; cell < cellCount(); ++cell) {
    const double j = smallestJacobian(cell, x);
    if (!(j >= jacobian)) jacobian = j, worst = cell;  // a NaN is the worst
    if (jacobian != jacobian) break;
  }
  return worst;
}

std::string HyperelasticForceField::worstElement(ConstRows x) const {
  double j = 0;
  const std::size_t cell = worstCell(ownRows(x), j);
  if (std::isnan(j) && !fault_.empty()) return fault_;
  const std::string text = fmt::format("{}: J = {:.3g}", describe(cell), j);
  return fault_.empty() ? text : text + "; " + fault_;
}

/// P of F, both in the material's axes.
Mat3 HyperelasticForceField::stress(std::size_t cell, std::size_t point, const Mat3& f) const {
  return viscous_ ? Mat3(f * viscous_->stress(cell, point, f)) : law_->stress(parameters(cell), f);
}

void HyperelasticForceField::cellField(const std::string& name, ConstRows x, std::vector<double>& out) const {
  const ConstRows own = ownRows(x);
  out.assign(name == "strain" ? 6 * cellCount() : cellCount(), 0.);
  for (std::size_t cell = 0; cell < cellCount(); ++cell) {
    if (name == "J") {
      out[cell] = smallestJacobian(cell, own);
      continue;
    }
    const std::vector<Mat3> points = deformations(cell, own);
    Mat3 mean = Mat3::Zero();  // of E or of Cauchy's stress P F^T / J
    for (std::size_t p = 0; p < points.size(); ++p) {
      const Mat3 &f = points[p], local = f * axes(cell);
      mean += name == "strain" ? Mat3((f.transpose() * f - Mat3::Identity()) / 2)
                               : Mat3(stress(cell, p, local) * local.transpose() / f.determinant());
    }
    mean /= double(points.size());
    if (name == "strain") {
      const double v[6] = {mean(0, 0), mean(1, 1), mean(2, 2), mean(0, 1), mean(1, 2), mean(2, 0)};
      std::copy(v, v + 6, out.begin() + std::ptrdiff_t(6 * cell));
    } else {
      out[cell] = std::sqrt(1.5) * (mean - mean.trace() / 3 * Mat3::Identity()).norm();
    }
  }
}

}  // namespace stroma
