// SPDX-License-Identifier: LGPL-2.1-or-later
// Linear tetrahedra with a rotation taken out of each element: small strains, large displacements.
//
// With R the rotation of an element, B its strain-displacement matrix and D Hooke's law,
//   f = R B^T D B (R^T x - X) V_0,      df = R B^T D B R^T dx V_0      (f is the restoring force with a minus sign)
// Source: M. Nesme, M. Marchal, E. Promayon, M. Chabanas, Y. Payan, F. Faure, "Physically realistic interactive
// simulation for biological soft tissues", Recent Research Developments in Biomechanics 2, 2005 (sections 2 to 3, 5.1,
// appendix A).
//
// method = small: R = I, pure linear elasticity; large: QR frame (first edge, plane of the first two), depends on the
// order of the vertices; polar: nearest orthogonal matrix, the least stretched axis flipped in an inverted element;
// svd: the smallest inversion (Irving et al. 2004); nodal: one rotation a node (Mueller et al. 2002), which leaves
// ghost forces and is here for comparison only. Other components' words qr, none, polar2, triangle, stable_polar and
// identity are taken as large, small, polar, large, svd and small.
//
// updateStiffnessMatrix rebuilds B from the current shape: forces then exert no torque on a body (Euler's law), which a
// constant B ensures only where stress and stretch share their axes (svd, and polar until an element inverts).
// updateVolume also updates the factor 1/6V of B and the volume. Both have a meaning for large, polar and svd. tangent
// = exact adds the derivatives of R and B: Newton's method converges quadratically. It is symmetric where the force has
// a potential: small, and svd without updates. polar has one until an element inverts; large and the updated variants
// have none. An unsymmetric tangent needs SparseLDLSolver.
//
// Cell fields for exporters: vonMises [Pa], J, strain (6 a cell: xx yy zz xy yz zx,
// sym(R^T F) - I for every variant, in the
// axes of the rest shape).
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <RegularGridTopology name="grid" n="3 3 9" min="0 0 0" max="0.02 0.02 0.1"/>
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-8"/>
//   <Node name="beam">
//     <TetrahedronSetTopologyContainer name="tets"/>
//     <Hexa2TetraTopologicalMapping input="@../grid" output="@tets" swapping="true"/>
//     <MechanicalObject/>
//     <DiagonalMass massDensity="1000"/>
//     <TetrahedronFEMForceField method="polar" youngModulus="1e5" poissonRatio="0.4"/>
//     <BoxROI name="held" box="-1 -1 -0.001 1 1 0.001"/>
//     <FixedProjectiveConstraint indices="@held.indices"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <Eigen/LU>

#include "framework/fem/isotropic.h"
#include "framework/fem/tetrahedron_method.h"
#include "framework/mechanics/force_field.h"
#include "framework/mesh/topology.h"
#include "framework/scene/factory.h"

using namespace stroma;

namespace {

using tetrahedron::Update;

enum class MethodWord : int { small, large, polar, svd, nodal, qr, none, polar2, triangle, stable_polar, identity };
enum class TangentWord : int { warped, exact };
enum class AssemblingWord : int { automatic, yes, no };

MethodWord canonical(MethodWord word) {
  switch (word) {
    case MethodWord::qr:
    case MethodWord::triangle:
      return MethodWord::large;
    case MethodWord::none:
    case MethodWord::identity:
      return MethodWord::small;
    case MethodWord::polar2:
      return MethodWord::polar;
    case MethodWord::stable_polar:
      return MethodWord::svd;
    default:
      return word;
  }
}

template <template <class, Update> class Form, class Rotation>
std::unique_ptr<tetrahedron::Method> makeUpdated(Update update, tetrahedron::Storage& storage) {
  switch (update) {
    case Update::none:
      return std::make_unique<Form<Rotation, Update::none>>(storage);
    case Update::strain_displacement:
      return std::make_unique<Form<Rotation, Update::strain_displacement>>(storage);
    default:
      return std::make_unique<Form<Rotation, Update::strain_displacement_and_volume>>(storage);
  }
}

template <template <class, Update> class Form>
std::unique_ptr<tetrahedron::Method> makeRotated(MethodWord method, Update update, tetrahedron::Storage& storage) {
  if (method == MethodWord::large) return makeUpdated<Form, rotation::Qr>(update, storage);
  if (method == MethodWord::polar) return makeUpdated<Form, rotation::Polar>(update, storage);
  return makeUpdated<Form, rotation::Svd>(update, storage);
}

M3<double> fromEigen(const Mat3& m) {
  return {{m(0, 0), m(1, 0), m(2, 0)}, {m(0, 1), m(1, 1), m(2, 1)}, {m(0, 2), m(1, 2), m(2, 2)}};
}
Mat3 toEigen(const M3<double>& m) {
  Mat3 out;
  out << m.c0.x, m.c1.x, m.c2.x, m.c0.y, m.c1.y, m.c2.y, m.c0.z, m.c1.z, m.c2.z;
  return out;
}

class TetrahedronFEMForceField final : public ForceField {
 public:
  MethodWord method_ = MethodWord::large;

  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.addLink("topology", topology_)
        .help("mesh that holds the tetrahedra; the node's own (or the nearest above) when not given");
    table.add("youngModulus", young_modulus_)
        .unit("Pa")
        .min(0, false)
        .physical()
        .help("Young's modulus: one value, or one a tetrahedron");
    table.add("poissonRatio", poisson_ratio_)
        .unit("-")
        .min(-1, false)
        .max(0.5, false)
        .physical()
        .help("Poisson's ratio: one value, or one a tetrahedron");
    table.add("localStiffnessFactor", stiffness_factor_)
        .unit("-")
        .min(0)
        .help("factor on Young's modulus a tetrahedron; empty: 1");
    table
        .addChoice(
            "method", method_,
            {"small", "large", "polar", "svd", "nodal", "qr", "none", "polar2", "triangle", "stable_polar", "identity"})
        .alias("rotationMethod")
        .help("how an element's rotation is found: small, large (QR), polar, svd, nodal");
    table.add("updateStiffnessMatrix", update_b_)
        .help("rebuild the strain-displacement matrix B from the current shape at every evaluation");
    table.add("updateVolume", update_volume_).help("update the volume factor 1/6V too (needs updateStiffnessMatrix)");
    table.addChoice("tangent", tangent_, {"warped", "exact"})
        .help("stiffness: R K R^T, or the exact derivative of the force");
    table.addChoice("assembling", assembling_, {"auto", "true", "false"})
        .alias("computeGlobalMatrix")
        .help(
            "keep this field's own assembled matrix for products: true, false, or auto (the linear solver's cost model "
            "decides)");
    table.add("plasticMaxThreshold", plastic_max_threshold_)
        .unit("-")
        .min(0)
        .help("largest plastic strain; only 0 (no plasticity) is available");
    declareWithoutEffect(table);
  }

  void init() override {
    ForceField::init();
    const Topology* topology = topology_.target() ? topology_.get() : find<Topology>(true);
    if (!topology) throw ComponentError("there is no mesh", "a topology with tetrahedra in this node or above");
    mesh_ = &topology->mesh();
    if (mesh_->tetrahedra.empty())
      throw ComponentError(fmt::format("{} holds no tetrahedra", topology->path()), "a mesh of tetrahedra",
                           mesh_->hexahedra.empty() ? "" : "cut its hexahedra with Hexa2TetraTopologicalMapping");
    method_ = canonical(method_);
    checkVariant();
    checkMaterial();
  }

  ForceTraits traits() const override {
    const bool linear = method_ == MethodWord::small, nodal = method_ == MethodWord::nodal;
    const bool potential = linear || (!update_b_ && method_ == MethodWord::svd);
    ForceTraits t;
    t.linear = t.constant_stiffness = linear;
    t.conservative = potential;
    t.exact_tangent = linear || tangent_ == TangentWord::exact;
    t.symmetric = nodal || tangent_ == TangentWord::warped || potential;
    t.forces_balance = !nodal;
    t.torques_balance = update_b_ || method_ == MethodWord::svd;
    return t;
  }

  void compile() override {
    const auto& cells = mesh_->tetrahedra;
    storage_.loop.build(cells, state().rest_position, state().firstRow());
    storage_.tangent.assign(std::size_t(storage_.loop.batches()), {});
    storage_.rest.assign(std::size_t(storage_.loop.batches()), {});
    for (Index b = 0; b < storage_.loop.batches(); ++b)
      for (int l = 0; l < pack_lanes; ++l) storeRestShape(b, l);
    const Update update = update_volume_ ? Update::strain_displacement_and_volume
                          : update_b_    ? Update::strain_displacement
                                         : Update::none;
    if (method_ == MethodWord::small)
      implementation_ = std::make_unique<tetrahedron::Linear>(storage_);
    else if (method_ == MethodWord::nodal)
      implementation_ = std::make_unique<tetrahedron::NodalWarping>(storage_);
    else if (tangent_ == TangentWord::warped)
      implementation_ = makeRotated<tetrahedron::Corotational>(method_, update, storage_);
    else
      implementation_ = makeRotated<tetrahedron::ExactCorotational>(method_, update, storage_);
  }

  double energy(ConstRows x) const override { return implementation_->energy(x); }

  void addForce(ConstRows x, ConstRows, Rows f) override {
    implementation_->addForce(x, f);
    refreshOwnMatrix(x.count);
  }
  void addForceAndProduct(ConstRows x, ConstRows v, ConstRows dx, double factor, Rows f, Rows df) override {
    if (assembling_ == AssemblingWord::yes) return ForceField::addForceAndProduct(x, v, dx, factor, f, df);
    implementation_->addForceAndProduct(x, dx, factor, f, df);
  }
  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override {
    if (assembling_ == AssemblingWord::yes)
      own_matrix_.multiplyAdd(factor, dx, df);
    else
      implementation_->addProduct(dx, factor, df);
  }

  void addPattern(BlockPattern& pattern) const override { storage_.loop.addPattern(pattern); }
  void prepareAssembly(const BlockMatrix& matrix) override { slots_ = storage_.loop.slots(matrix); }
  void addStiffness(double factor, BlockMatrix& matrix) const override {
    implementation_->assemble(factor, slots_, matrix.values());
  }
  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override {
    implementation_->assembleDiagonal(factor, blocks);
  }

  /// Measured on one core at 2.6 GHz with 8 lanes; in proportion for fewer. An element's own assembly is its scatter.
  Cost cost() const override {
    const double lanes = 8. / pack_lanes, n = double(storage_.loop.elements());
    if (assembling_ == AssemblingWord::no) return {0, 1e30};
    if (assembling_ == AssemblingWord::yes) return {2.5 * own_matrix_.blocks(), 1e30};  // one matrix is enough
    return {n * (tangent_ == TangentWord::exact ? 40 : method_ == MethodWord::nodal ? 30 : 4.6) * lanes, n * 100};
  }

  std::string worstElement(ConstRows x) const override {
    double worst = std::numeric_limits<double>::infinity();
    std::size_t at = 0;
    for (std::size_t e = 0; e < mesh_->tetrahedra.size(); ++e) {
      const double j = deformationGradient(e, x).determinant();
      if (!(j >= worst)) worst = j, at = e;  // a NaN is the worst
      if (worst != worst) break;
    }
    const auto& t = mesh_->tetrahedra[at];
    return fmt::format("tetrahedron {} (nodes {} {} {} {}): J = {:.3g}", at, t[0], t[1], t[2], t[3], worst);
  }

  std::vector<std::string> cellFields() const override { return {"vonMises", "J", "strain"}; }
  void cellField(const std::string& name, ConstRows x, std::vector<double>& out) const override {
    const std::size_t count = mesh_->tetrahedra.size();
    out.resize(name == "strain" ? 6 * count : count);
    for (std::size_t e = 0; e < count; ++e) {
      const Mat3 f = deformationGradient(e, x);
      if (name == "J") {
        out[e] = f.determinant();
        continue;
      }
      const Mat3 strain = coRotatedStrain(e, f);
      if (name == "strain") {
        const double v[6] = {strain(0, 0), strain(1, 1), strain(2, 2), strain(0, 1), strain(1, 2), strain(2, 0)};
        std::copy(v, v + 6, out.begin() + std::ptrdiff_t(6 * e));
      } else {
        const Mat3 deviator = 2 * lame(e).mu * (strain - strain.trace() / 3 * Mat3::Identity());
        out[e] = std::sqrt(1.5) * deviator.norm();
      }
    }
  }

 private:
  /// SOFA's attributes for drawing, for its GPU and for choosing between its implementations.
  static void declareWithoutEffect(DataTable& table) {
    for (const char* name : {"plasticYieldThreshold",
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
                             "gatherPt",
                             "gatherBsize",
                             "elementSpace",
                             "computeForceStrategy",
                             "computeForceDerivStrategy"})
      table.addVisualOnly(name);
  }

  void checkVariant() const {
    if (update_volume_ && !update_b_)
      throw ComponentError("updateVolume has no meaning while B is constant", "updateStiffnessMatrix=\"true\" with it");
    const bool rotated = method_ == MethodWord::large || method_ == MethodWord::polar || method_ == MethodWord::svd;
    if (update_b_ && !rotated)
      throw ComponentError(fmt::format("updateStiffnessMatrix has no meaning for method {}",
                                       method_ == MethodWord::small ? "small" : "nodal"),
                           "method large, polar or svd");
    if (tangent_ == TangentWord::exact && method_ == MethodWord::nodal)
      throw ComponentError("method nodal has no exact tangent", "tangent=\"warped\" (its symmetric part)");
    if (plastic_max_threshold_ > 0) throw ComponentError("plasticity is not available", "plasticMaxThreshold=\"0\"");
  }

  void checkMaterial() const {
    const std::size_t count = mesh_->tetrahedra.size();
    const auto check = [&](const char* name, const std::vector<double>& values, bool may_be_empty) {
      if ((may_be_empty && values.empty()) || values.size() == 1 || values.size() == count) return;
      throw ComponentError(fmt::format("{} has {} values", name, values.size()),
                           fmt::format("1, or {} (one a tetrahedron)", count));
    };
    check("youngModulus", young_modulus_, false);
    check("poissonRatio", poisson_ratio_, false);
    check("localStiffnessFactor", stiffness_factor_, true);
    const std::string problem = mesh_->firstError();
    if (!problem.empty()) throw ComponentError(problem);
    if (mesh_->nodes() > state().size())
      throw ComponentError(
          fmt::format("the mesh has {} nodes, {} has {}", mesh_->nodes(), state().path(), state().size()),
          "the same number");
    for (std::size_t e = 0; e < count; ++e) {
      const Mat3 edges = restEdges(e);
      const double longest = edges.colwise().norm().maxCoeff();
      if (!(std::abs(edges.determinant()) > 1e-12 * longest * longest * longest)) {
        const auto& t = mesh_->tetrahedra[e];
        throw ComponentError(
            fmt::format("tetrahedron {} (nodes {} {} {} {}) is flat at rest", e, t[0], t[1], t[2], t[3]), "a volume");
      }
    }
  }

  static double at(const std::vector<double>& values, std::size_t e, double empty) {
    return values.empty() ? empty : values.size() == 1 ? values[0] : values[e];
  }
  Lame lame(std::size_t e) const {
    return Lame::from(at(young_modulus_, e, 0) * at(stiffness_factor_, e, 1), at(poisson_ratio_, e, 0));
  }
  Mat3 edgesOf(std::size_t e, auto&& position) const {
    const auto& t = mesh_->tetrahedra[e];
    const Vec3 a = position(t[0]);
    Mat3 edges;
    edges << position(t[1]) - a, position(t[2]) - a, position(t[3]) - a;
    return edges;
  }
  Mat3 restEdges(std::size_t e) const {
    return edgesOf(e, [&](Index n) -> Vec3 { return state().rest_position[std::size_t(n)]; });
  }
  Mat3 deformationGradient(std::size_t e, ConstRows x) const {
    return edgesOf(e, [&](Index n) -> Vec3 { return x[state().firstRow() + n]; }) * restEdges(e).inverse();
  }
  /// The frame in which the rest shape is stored: first edge on x, second in the xy plane. Columns are its axes.
  Mat3 restFrame(std::size_t e) const {
    const Mat3 edges = restEdges(e);
    return toEigen(rotation::gramSchmidt(fromEigen(edges / edges.norm())));
  }
  /// The strain that the method sees, turned back to the axes of the rest shape.
  Mat3 coRotatedStrain(std::size_t e, const Mat3& f) const {
    if (method_ == MethodWord::small) return (f + f.transpose()) / 2 - Mat3::Identity();
    const Mat3 frame = restFrame(e);
    const M3<double> local = fromEigen(f * frame);
    const M3<double> r = method_ == MethodWord::large   ? rotation::Qr::of(local)
                         : method_ == MethodWord::polar ? rotation::Polar::of(local)
                                                        : rotation::Svd::of(local);
    const S3<double> s = rotation::stretch(r, local);
    Mat3 strain;
    strain << s.xx - 1, s.xy, s.zx, s.xy, s.yy - 1, s.yz, s.zx, s.yz, s.zz - 1;
    return frame * strain * frame.transpose();
  }

  /// D_m in the element's own frame and the rest gradients in world axes. A padding lane has no stiffness.
  void storeRestShape(Index b, int l) {
    const Index cell = storage_.loop.elementOf(b, l);
    const std::size_t e = std::size_t(cell >= 0 ? cell : storage_.loop.elementOf(b, 0));
    const Mat3 edges = restEdges(e), q = restFrame(e);
    const Mat3 local = (q.transpose() * edges).triangularView<Eigen::Upper>();
    const Mat3 inverse = local.inverse();
    auto& rest = storage_.rest[std::size_t(b)];
    auto& tangent = storage_.tangent[std::size_t(b)];
    const int row[6] = {0, 0, 1, 0, 1, 2}, column[6] = {0, 1, 1, 2, 2, 2};
    for (int i = 0; i < 6; ++i)
      rest.edges[i][l] = local(row[i], column[i]), rest.inverse[i][l] = inverse(row[i], column[i]);
    const double six_volume = local.diagonal().prod();
    rest.inverse_six_volume[l] = 1 / six_volume;
    const Mat3 gradients = (inverse * q.transpose()).transpose();  // column i: g_{i+1}
    for (int i = 0; i < 9; ++i) tangent.g[i][l] = gradients(i % 3, i / 3);
    // cells that cover the body twice share its stiffness
    const double volume = cell >= 0 ? std::abs(six_volume) / 6 / mesh_->overlap : 0;
    tangent.lambda[l] = lame(e).lambda * volume;
    tangent.mu[l] = lame(e).mu * volume;
  }

  void refreshOwnMatrix(Index rows) {
    if (assembling_ != AssemblingWord::yes) return;
    const bool first = own_matrix_.rows() != rows;
    if (first) {
      BlockPattern pattern(rows);
      addPattern(pattern);
      own_matrix_ = BlockMatrix(std::move(pattern));
      own_slots_ = storage_.loop.slots(own_matrix_);
    }
    if (!first && traits().constant_stiffness) return;
    own_matrix_.clear();
    implementation_->assemble(1, own_slots_, own_matrix_.values());
  }

  Link<Topology> topology_{"topology"};
  std::vector<double> young_modulus_{5000}, poisson_ratio_{0.45}, stiffness_factor_;
  bool update_b_ = false, update_volume_ = false;
  TangentWord tangent_ = TangentWord::warped;
  AssemblingWord assembling_ = AssemblingWord::automatic;
  double plastic_max_threshold_ = 0;

  const Mesh* mesh_ = nullptr;
  tetrahedron::Storage storage_;
  std::unique_ptr<tetrahedron::Method> implementation_;
  std::vector<Index> slots_, own_slots_;
  BlockMatrix own_matrix_;
};

}  // namespace

STROMA_COMPONENT(tetrahedron_fem_force_field) {
  using Field = TetrahedronFEMForceField;
  const std::string help = "corotational linear tetrahedra: small, large (QR), polar, svd, nodal";
  factory.add<Field>("TetrahedronFEMForceField", help);
  factory.add<Field>("TetrahedralCorotationalFEMForceField", help);
  factory.add<Field>("FastTetrahedralCorotationalForceField", help, [](Field& f) { f.method_ = MethodWord::qr; });
  factory.add<Field>("CorotationalFEMForceField", help, [](Field& f) { f.method_ = MethodWord::triangle; });
}
