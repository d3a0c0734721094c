// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/elasticity/elastic_force_field.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "framework/mechanics/state_topology.h"
#include "framework/scene/names.h"

namespace stroma {

namespace {

/// "quadratic tetrahedron" of "QuadraticTetrahedron".
std::string lowerCase(const std::string& word) {
  std::string text;
  for (const char c : word) {
    if (std::isupper(static_cast<unsigned char>(c)) && !text.empty()) text += ' ';
    text += char(std::tolower(c));
  }
  return text;
}

ElasticMethod canonical(ElasticForceField::Word word) {
  using Word = ElasticForceField::Word;
  switch (word) {
    case Word::qr:
    case Word::triangle:
    case Word::hexahedron:
      return ElasticMethod::large;
    case Word::none:
    case Word::identity:
      return ElasticMethod::small;
    case Word::polar2:
      return ElasticMethod::polar;
    case Word::stable_polar:
      return ElasticMethod::svd;
    case Word::green_lagrange:
      return ElasticMethod::green;
    default:
      return ElasticMethod(int(word));
  }
}

const char* wordOf(ElasticMethod method) {
  constexpr const char* words[] = {"small", "large", "polar", "svd", "nodal", "green"};
  return words[int(method)];
}

/// One value for all, or one per cell.
double at(const std::vector<double>& values, std::size_t cell, double empty) {
  return values.empty() ? empty : values.size() == 1 ? values[0] : values[cell];
}

/// SOFA's attributes for drawing, for its GPU and for choosing between its implementations.
constexpr const char* without_effect[] = {"plasticYieldThreshold",
                                          "plasticCreep",
                                          "computeVonMisesStress",
                                          "showStressColorMap",
                                          "showStressAlpha",
                                          "showVonMisesStressPerNode",
                                          "showVonMisesStressPerNodeColorMap",
                                          "showVonMisesStressPerElement",
                                          "showElementGapScale",
                                          "drawHeterogeneousTetra",
                                          "drawing",
                                          "drawColor1",
                                          "drawColor2",
                                          "drawColor3",
                                          "drawColor4",
                                          "drawPercentageOffset",
                                          "gatherPt",
                                          "gatherBsize",
                                          "elementSpace",
                                          "computeForceStrategy",
                                          "computeForceDerivStrategy"};

}  // namespace

void ElasticForceField::declare(DataTable& table) {
  ForceField::declare(table);
  topology_.declare(table, "mesh that holds the cells");
  table.add("template", template_)
      .help("Vec3, or the kind of cell with it where a mesh holds several: Vec3,Tetrahedron, Vec3,Hexahedron, Vec3,Prism or Vec3,Pyramid");
  table.add("youngModulus", young_modulus_)
      .recompiled()
      .unit("Pa")
      .min(0, false)
      .physical()
      .ofCells()
      .help("Young's modulus: one value, or one per cell");
  table.add("poissonRatio", poisson_ratio_)
      .recompiled()
      .unit("-")
      .min(-1, false)
      .max(0.5, false)
      .physical()
      .ofCells()
      .help("Poisson's ratio: one value, or one per cell");
  table.add("firstForOthers", first_for_others_)
      .help("cells beyond the end of a list of youngModulus or poissonRatio take its first value, as in SOFA");
  table.add("localStiffnessFactor", stiffness_factor_)
      .recompiled()
      .unit("-")
      .min(0)
      .ofCells()
      .help("factor on Young's modulus, one per cell; empty: 1");
  table
      .addChoice("method", method_word,
                 {"small", "large", "polar", "svd", "nodal", "green", "qr", "none", "polar2", "triangle", "hexahedron",
                  "stable_polar", "identity", "green_lagrange"})
      .alias("rotationMethod")
      .help(
          "how an element's rotation is found: small (none), large (QR), polar, svd, nodal; or green: no rotation, "
          "Green-Lagrange strain");
  table.add("updateStiffnessMatrix", update_b_)
      .help("rebuild the strain-displacement matrix B from the current shape at every evaluation");
  table.add("updateVolume", update_volume_).help("update the volume factor of B too (needs updateStiffnessMatrix)");
  table.addChoice("tangent", tangent_, {"warped", "exact"})
      .help("stiffness: R K R^T, or the exact derivative of the force");
  table.addChoice("dilatation", dilatation_, {"auto", "local", "mean"})
      .help("volume change: that at each integration point, or its mean (over a hexahedron, around a node of tetrahedra), which does "
            "not lock at Poisson ratios near 1/2; auto: the mean above 0.45 for tetrahedra, from 0.4 on for others");
  table.addChoice("polarOf", polar_of_, {"gradient", "edges", "nodes"})
      .help("method polar or svd: what matrix's polar factor turns a cell, F or (SOFA) that of edges or sum (x - c)(X - C)^T of nodes");
  table.add("reducedIntegration", reduced_).help("prisms by two points, as in SOFA, for method small or polarOf nodes");
  if (std::any_of(kinds.begin(), kinds.end(), [](const ElasticKind& kind) { return kind.word == "Hexahedron"; }))
    table.add("incompatibleModes", incompatible_).help("hexahedra bend by nine numbers more, twelve with a mean; condensed beforehand");
  table.addChoice("assembling", assembling_, {"auto", "true", "false"})
      .alias("computeGlobalMatrix")
      .help(
          "keep this field's own assembled matrix for products: true, false, or auto (the linear solver's cost model "
          "decides)");
  table.add("plasticMaxThreshold", plastic_max_threshold_)
      .unit("-")
      .min(0)
      .help("largest plastic strain; only 0 (no plasticity) is available");
  for (const char* name : without_effect) table.addVisualOnly(name);
}

// The kind that the template names; else the one that the mesh holds.
void ElasticForceField::chooseKind(const Topology& topology) {
  std::vector<std::string> words, plurals;
  for (const ElasticKind& kind : kinds) {
    words.push_back("Vec3," + kind.word);
    plurals.push_back(kind.plural);
  }
  const auto comma = template_.find(',');
  const std::string vector = template_.substr(0, comma),
                    wanted = comma == std::string::npos ? "" : template_.substr(comma + 1);
  const bool known = wanted.empty() ||
                     std::any_of(kinds.begin(), kinds.end(), [&](const auto& kind) { return kind.word == wanted; });
  if (!known || (!vector.empty() && vector != "Vec3" && vector != "Vec3d" && vector != "Vec3f"))
    throw ComponentError(fmt::format("template '{}' is none that {} has", template_, type()),
                         fmt::format("Vec3, {}", fmt::join(words, ", ")), nearest(template_, words));

  std::vector<const ElasticKind*> found;
  for (const ElasticKind& kind : kinds)
    if ((wanted.empty() || kind.word == wanted) && kind.make()->count(topology.mesh()) > 0) found.push_back(&kind);
  if (found.size() > 1)
    throw ComponentError(fmt::format("{} holds {}", topology.path(), fmt::join(plurals, " and ")),
                         "one force field for each kind of cell",
                         fmt::format("template=\"{}\"", fmt::join(words, "\" or template=\"")));
  if (found.empty()) {
    if (!wanted.empty())
      for (const ElasticKind& kind : kinds)
        if (kind.word == wanted) plurals = {kind.plural};
    const bool may_cut = !topology.mesh().hexahedra.empty();
    throw ComponentError(fmt::format("{} holds no {}", topology.path(), fmt::join(plurals, " and no ")),
                         fmt::format("a mesh of {}", fmt::join(plurals, " or ")),
                         may_cut ? "cut its hexahedra with Hexa2TetraTopologicalMapping, or HexahedronFEMForceField"
                         : topology.mesh().tetrahedra.empty() ? ""
                                                              : "TetrahedronFEMForceField");
  }
  if (reduced_ && !found[0]->make_reduced)
    throw ComponentError(fmt::format("there is no reduced integration of {}", found[0]->plural), "reducedIntegration=\"false\"");
  make_elements_ = reduced_ ? found[0]->make_reduced : found[0]->make;
  elements_ = newElements();
  kind_word_ = lowerCase(found[0]->word);
}

void ElasticForceField::init() {
  ForceField::init();
  const Topology* topology = topology_.find(*this, state(), MeshNodes::first);
  if (!topology) throw ComponentError("there is no mesh", "a topology with cells in this node or above");
  mesh_ = &topology->mesh();
  method_.reset(), other_method_.reset(), other_elements_.reset();  // before the shapes that they look at
  chooseKind(*topology);
  variant_.method = canonical(method_word);
  variant_.update = update_volume_ ? elastic::Update::strain_displacement_and_volume
                    : update_b_    ? elastic::Update::strain_displacement
                                   : elastic::Update::none;
  variant_.exact_tangent = tangent_ == Tangent::exact;
  variant_.own_matrix = assembling_ == Assembling::yes;
  compileMaterial();
  if (polar_of_ != PolarOf::gradient) {
    const bool turns = variant_.method == ElasticMethod::polar || variant_.method == ElasticMethod::svd;
    if (!turns || variant_.exact_tangent || variant_.mean_dilatation || update_b_ || !elements_->usePolarOf(polar_of_))
      throw ComponentError("polarOf is of method polar of linear cells (of prisms and pyramids: nodes), with local dilatation and "
                           "constant B", "polarOf=\"gradient\"");
  }
  elements_->bind(*mesh_, state().rest_position, variant_);
}

void ElasticForceField::compileMaterial() {
  readMaterial();
  const bool is_other = chooseDilatation();
  checkVariant();
  tellSurprises();
  if (is_other && method_) {
    elements_->bind(*mesh_, state().rest_position, variant_);
    method_.reset();
  }
}

// What may change while a scene runs is the material: kinds, shapes and the order of the elements stay.
void ElasticForceField::recompile() { compileMaterial(); }

void ElasticForceField::tellSurprises() const {
  if (variant_.method == ElasticMethod::large && elements_->updatesStrainDisplacement())
    inform(
        fmt::format("method large takes the frame of an element from the order of its nodes: it fails the patch test by the square "
                    "of the strain{}. method svd has neither problem",
                    update_b_ ? ""
                              : ", and of a constant B (updateStiffnessMatrix=\"false\") its forces turn a free body, "
                                "by about the square of the strain too"));
  const bool rotated = variant_.method != ElasticMethod::small && variant_.method != ElasticMethod::green;
  const double largest = *std::max_element(poisson_ratio_.begin(), poisson_ratio_.end());
  constexpr double locking = 0.45, nearly_incompressible = 0.49;
  if (!variant_.mean_dilatation && largest > locking)
    warn(fmt::format(
             "poissonRatio {:g} with a volume change at each integration point locks: a body is far too stiff in "
             "bending{}",
             largest, dilatation_ == Dilatation::automatic ? "; " + whyNoMean() : ""),
         dilatation_ == Dilatation::automatic ? "method=\"svd\", or hexahedra" : "dilatation=\"mean\"");
  if (variant_.mean_dilatation && rotated && !variant_.exact_tangent && largest > nearly_incompressible)
    inform(
        "with a warped tangent Newton's method slows down and may stall this near to incompressibility: "
        "tangent=\"exact\" "
        "converges quadratically");
}

/// Why there is no mean dilatation, or empty.
std::string ElasticForceField::whyNoMean() const {
  if (!elements_->hasMeanDilatation(variant_.method))
    return fmt::format("method {} has no mean dilatation for a {}", wordOf(variant_.method), kind_word_);
  std::set<double> bulk;
  for (const Lame& constants : constants_) bulk.insert(constants.bulk());
  if (bulk.size() > elements_->mostMaterials())
    return fmt::format("{} bulk moduli are more than the mean dilatation of a {} takes ({})", bulk.size(), kind_word_,
                       elements_->mostMaterials());
  return {};
}

bool ElasticForceField::chooseDilatation() {
  const bool before = variant_.mean_dilatation;
  variant_.mean_dilatation = dilatation_ == Dilatation::mean;
  if (dilatation_ != Dilatation::automatic) return variant_.mean_dilatation != before;
  const double largest = *std::max_element(poisson_ratio_.begin(), poisson_ratio_.end());
  if (largest >= elements_->meanDilatationFrom()) variant_.mean_dilatation = whyNoMean().empty();
  return variant_.mean_dilatation != before;
}

std::string ElasticForceField::choice() const {
  if (dilatation_ != Dilatation::automatic) return {};
  return variant_.mean_dilatation ? "mean dilatation" : "local dilatation";
}

void ElasticForceField::checkVariant() const {
  const ElasticMethod method = variant_.method;
  if (only_small && method != ElasticMethod::small)
    throw ComponentError(type() + " is linear, without rotations", "method=\"small\"", "CorotationalFEMForceField");
  if (!elements_->has(method))
    throw ComponentError(fmt::format("method {} does not exist for a {}", wordOf(method), kind_word_),
                         "method small, large, polar, svd or green");
  if (update_volume_ && !update_b_)
    throw ComponentError("updateVolume has no meaning while B is constant", "updateStiffnessMatrix=\"true\" with it");
  const bool rotated = method == ElasticMethod::large || method == ElasticMethod::polar || method == ElasticMethod::svd;
  if (update_b_ && !elements_->updatesStrainDisplacement())
    throw ComponentError(fmt::format("updateStiffnessMatrix does not exist for a {}", kind_word_),
                         "updateStiffnessMatrix=\"false\"");
  if (update_b_ && !rotated)
    throw ComponentError(fmt::format("updateStiffnessMatrix has no meaning for method {}", wordOf(method)),
                         "method large, polar or svd");
  if (variant_.exact_tangent && method == ElasticMethod::nodal)
    throw ComponentError("method nodal has no exact tangent", "tangent=\"warped\" (its symmetric part)");
  if (method == ElasticMethod::green && isSet("tangent") && !variant_.exact_tangent)
    throw ComponentError("method green has no rotations: it has no warped tangent", "tangent=\"exact\"");
  if (variant_.mean_dilatation) checkMeanDilatation();
  if (incompatible_) checkIncompatibleModes();
  if (plastic_max_threshold_ > 0) throw ComponentError("plasticity is not available", "plasticMaxThreshold=\"0\"");
}

void ElasticForceField::checkMeanDilatation() const {
  if (!elements_->hasMeanDilatation(variant_.method)) throw ComponentError(whyNoMean(), "dilatation=\"local\"");
}

void ElasticForceField::readMaterial() {
  const std::size_t count = std::size_t(elements_->count(*mesh_));
  const auto check = [&](const char* name, std::vector<double>& values, bool is_factor) {
    const std::size_t given = values.size();
    if ((is_factor && given == 0) || given == 1 || given == count) return;
    const std::string found = fmt::format("{} has {} values", name, given);
    if (!first_for_others_ || is_factor || given == 0)
      throw ComponentError(found, fmt::format("1, or {} (one per {})", count, kind_word_));
    warn(fmt::format("{} for {} cells: {}", found, count, given < count ? "the others take the first" : "those beyond are left out"));
    values.resize(count, double(values.front()));
  };
  check("youngModulus", young_modulus_, false);
  check("poissonRatio", poisson_ratio_, false);
  check("localStiffnessFactor", stiffness_factor_, true);
  const std::string problem = mesh_->firstError();
  if (!problem.empty()) throw ComponentError(problem);
  const bool is_list = young_modulus_.size() > 1 || poisson_ratio_.size() > 1 || !stiffness_factor_.empty();
  constants_.resize(is_list ? count : 1);
  for (std::size_t cell = 0; cell < constants_.size(); ++cell)
    constants_[cell] =
        Lame::from(at(young_modulus_, cell, 0) * at(stiffness_factor_, cell, 1), at(poisson_ratio_, cell, 0));
}

ForceTraits ElasticForceField::traits() const {
  const bool linear = variant_.method == ElasticMethod::small, nodal = variant_.method == ElasticMethod::nodal;
  const bool green = variant_.method == ElasticMethod::green;
  const bool svd_potential =
      variant_.method == ElasticMethod::svd && !update_b_ && elements_ && elements_->rotationHasPotential();
  const bool potential = linear || green || (svd_potential && polar_of_ == PolarOf::gradient);
  ForceTraits t;
  t.linear = t.constant_stiffness = linear;
  t.conservative = potential;
  t.exact_tangent = linear || green || variant_.exact_tangent;
  t.symmetric = nodal || !variant_.exact_tangent || potential;
  t.forces_balance = !nodal;
  t.has_rest_shape = true;
  t.torques_balance = update_b_ || green || (svd_potential && polar_of_ == PolarOf::gradient);
  return t;
}

void ElasticForceField::compile() {
  other_method_.reset(), other_elements_.reset();
  if (method_ && first_row_ == state().firstRow() && method_->refill()) return;
  method_ = makeMethod(*elements_);
  first_row_ = state().firstRow();
}

std::unique_ptr<ElementKernels> ElasticForceField::makeMethod(const ElasticElements& elements) const {
  return elements.make(state().firstRow(), LameOf(constants_));
}

bool ElasticForceField::useExactTangent(bool exact) {
  // a tangent that the scene names stays
  const bool has_other = tangent_ == Tangent::warped && !data().find("tangent")->isSet() &&
                         variant_.method != ElasticMethod::small && variant_.method != ElasticMethod::green &&
                         variant_.method != ElasticMethod::nodal && polar_of_ == PolarOf::gradient;
  if (!has_other || variant_.exact_tangent == exact) return has_other;
  variant_.exact_tangent = exact;
  if (!other_method_) {
    other_elements_ = newElements();
    other_elements_->bind(*mesh_, state().rest_position, variant_);
    other_method_ = makeMethod(*other_elements_);
  }
  std::swap(elements_, other_elements_);
  std::swap(method_, other_method_);
  if (!elements_->tangentsLieAlike()) ++tangent_changes_;
  return true;
}

bool ElasticForceField::keepTurning(bool on) {
  auto* const kernels = data().find("tangent")->isSet() ? nullptr : dynamic_cast<TurnsStresses*>(method_.get());
  return kernels && kernels->keepTurning(on);
}

void ElasticForceField::addTurning(double part) {
  if (auto* const kernels = dynamic_cast<TurnsStresses*>(method_.get())) kernels->addTurning(part);
}

/// Measured on one core at 2.6 GHz with 8 lanes; in proportion for fewer. An element's own assembly is its scatter.
ForceField::Cost ElasticForceField::cost() const {
  const double cells = double(elements_->count(*mesh_));
  const ElasticElements::Nanoseconds each = elements_->cost();
  // a matrix of its own is enough, and so is none
  const bool fixed = assembling_ != Assembling::automatic;
  return {cells * each.product, fixed ? 1e30 : cells * each.assembly};
}

}  // namespace stroma
