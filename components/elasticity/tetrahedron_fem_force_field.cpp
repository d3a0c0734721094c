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
// svd: the smallest inversion (Irving et al. 2004); nodal: one rotation per node (Mueller et al. 2002), which leaves
// ghost forces and is here for comparison only. Other components' words qr, none, polar2, triangle, stable_polar and
// identity are taken as large, small, polar, large, svd and small.
//
// method = green is the nonlinear geometric reference without rotations: St. Venant-Kirchhoff,
//   E = (F^T F - I)/2,   S = lambda tr(E) I + 2 mu E,   f_i = -V_0 F S G_i,   W = V_0 (lambda/2 tr(E)^2 + mu E : E)
// It has a potential and an exact, symmetric tangent. It softens under strong compression: that is the law.
//
// updateStiffnessMatrix rebuilds B from the current shape: forces then exert no torque on a body (Euler's law), which a
// constant B ensures only where stress and stretch share their axes (svd, and polar until an element inverts).
// updateVolume also updates the factor 1/6V of B and the volume. Both have a meaning for large, polar and svd. tangent
// = exact adds the derivatives of R and B: Newton's method converges quadratically. It is symmetric where the force has
// a potential: small, and svd without updates. polar has one until an element inverts; large and the updated variants
// have none. An unsymmetric tangent needs SparseLDLSolver.
//
// dilatation = mean takes the volume change as one number per node, the mean over the tetrahedra around it (Bonet and
// Burton 1998):
//   V_a = sum V_e/4,   theta_a = 1/V_a sum V_e/4 tr(eps_e),   p_e = 1/4 sum_a K theta_a,   sigma_e = p_e I + 2 mu
//   dev(eps_e)
// Near nu = 1/2 the mesh does not lock, and a compressed body does not buckle element by element under the pressures of
// locking. For small, large, polar and svd. A product passes twice over the elements; a matrix couples the nodes of all
// elements around each node. With updateVolume an element counts with (V V_0)^1/2.
//
// Cell fields for exporters: vonMises [Pa], J, strain (6 per cell: xx yy zz xy yz zx, sym(R^T F) - I for every variant,
// E for green, in the axes of the rest shape).
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
#include <map>

#include "components/elasticity/elastic_force_field.h"
#include "components/elasticity/elastic_kernels.h"
#include "components/elasticity/nodal_dilatation.h"
#include "framework/fem/eigen_matrix.h"
#include "framework/scene/factory.h"

using namespace stroma;

namespace {

using tetrahedron::Update;

class Tetrahedra final : public ElasticElements {
 public:
  Index count(const Mesh& mesh) const override { return Index(mesh.tetrahedra.size()); }
  bool has(ElasticMethod) const override { return true; }
  bool hasMeanDilatation(ElasticMethod method) const override {
    return method != ElasticMethod::green && method != ElasticMethod::nodal;
  }
  bool rotationHasPotential() const override { return true; }

  void bind(const Mesh& mesh, const std::vector<Vec3>& rest, const ElasticVariant& variant) override {
    mesh_ = &mesh, rest_ = &rest, variant_ = variant;
    for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
      const Mat3 edges = restEdges(mesh.tetrahedra[e]);
      const double longest = edges.colwise().norm().maxCoeff();
      if (!(std::abs(edges.determinant()) > 1e-12 * longest * longest * longest))
        throw ComponentError(describe(e) + " is flat at rest", "a volume");
    }
  }

  std::unique_ptr<ElementKernels> make(Index first_row, const std::function<Lame(std::size_t)>& lame) const override {
    const bool nodal = variant_.method == ElasticMethod::nodal;
    return withOwnMatrix(variant_, nodal ? makeNodal(first_row, lame) : makeFans(first_row, lame));
  }

  std::string describe(std::size_t e) const override {
    const auto& t = mesh_->tetrahedra[e];
    return fmt::format("tetrahedron {} (nodes {} {} {} {})", e, t[0], t[1], t[2], t[3]);
  }
  double jacobian(std::size_t e, ConstRows x) const override { return deformationGradient(e, x).determinant(); }
  Mat3 strain(std::size_t e, ConstRows x) const override {
    const Mat3 f = deformationGradient(e, x);
    if (variant_.method == ElasticMethod::small) return (f + f.transpose()) / 2 - Mat3::Identity();
    if (variant_.method == ElasticMethod::green) return (f.transpose() * f - Mat3::Identity()) / 2;
    const Mat3 frame = restFrame(e);
    const M3<double> local = fromEigen(f * frame);
    const M3<double> r = variant_.method == ElasticMethod::large   ? rotation::Qr::of(local)
                         : variant_.method == ElasticMethod::polar ? rotation::Polar::of(local)
                                                                   : rotation::Svd::of(local);
    return frame * (toEigen(rotation::stretch(r, local)) - Mat3::Identity()) * frame.transpose();
  }
  double strainBeyond(double limit, std::size_t e, ConstRows x) const override {
    return principalBeyond(limit, strain(e, x), variant_.method == ElasticMethod::green);
  }
  Nanoseconds cost() const override {
    const double lanes = 8. / pack_lanes;
    const bool green = variant_.method == ElasticMethod::green, nodal = variant_.method == ElasticMethod::nodal;
    return {(green ? 12 : variant_.exact_tangent ? 40 : nodal ? 30 : 4.6) * lanes, 100};
  }

 private:
  using LameOf = std::function<Lame(std::size_t)>;

  std::unique_ptr<ElementKernels> makeNodal(Index first_row, const LameOf& lame) const {
    StorageOf<tetrahedron::NodalModel> storage;
    storage.build(mesh_->tetrahedra, *rest_, first_row, [&](std::size_t e, bool padding, auto& rest, auto& tangent) {
      setElement(e, mesh_->tetrahedra[e], padding, lame, rest, tangent);
    });
    return std::make_unique<tetrahedron::NodalWarping>(std::move(storage));
  }

  template <class Storage>
  Storage fanStorage(const std::vector<tetrahedron::Fan>& fans, Index first_row, const LameOf& lame) const {
    using namespace tetrahedron;
    std::vector<std::array<Index, fan_nodes>> cells;
    cells.reserve(fans.size());
    for (const Fan& fan : fans) cells.push_back(fan.nodes);
    Storage storage;
    storage.build(cells, *rest_, first_row, [&](std::size_t f, bool padding, auto& rest, auto& tangent) {
      for (int i = 0; i < fan_size; ++i) {
        const Index e = fans[f].element[i];
        Tetrahedron nodes;
        for (int a = 0; a < 4; ++a) nodes[a] = cells[f][corner(i, a)];
        setElement(std::size_t(e >= 0 ? e : fans[f].element[0]), nodes, padding || e < 0, lame, rest.of[i],
                   tangent.of[i]);
      }
    });
    return storage;
  }
  /// Cells by their bulk modulus.
  std::map<double, std::vector<Index>> materials(const LameOf& lame) const {
    std::map<double, std::vector<Index>> cells;
    for (std::size_t e = 0; e < mesh_->tetrahedra.size(); ++e)
      cells[lame(e).lambda + 2. / 3 * lame(e).mu].push_back(Index(e));
    constexpr std::size_t most = 100;
    if (cells.size() > most)
      throw ComponentError(fmt::format("the mean dilatation is taken over cells with equal constants, and there are {} "
                                       "bulk moduli",
                                       cells.size()),
                           fmt::format("at most {} materials", most), "dilatation=\"local\"");
    return cells;
  }
  template <class Single>
  std::unique_ptr<ElementKernels> makeAveraged(Index first_row, const LameOf& lame) const {
    using namespace tetrahedron;
    std::vector<AveragedCells<Single>> all;
    for (const auto& [bulk, numbers] : materials(lame)) {
      AveragedCells<Single>& m = all.emplace_back();
      std::vector<double> volume;
      for (Index e : numbers) {
        m.cells.push_back(mesh_->tetrahedra[e]);
        volume.push_back(weight(restEdges(m.cells.back())));
      }
      m.fans = gatherFans(m.cells, rest_->size());
      std::vector<Fan> fans = m.fans;  // with numbers of the mesh
      for (Fan& fan : fans)
        for (Index& e : fan.element) e = e >= 0 ? numbers[e] : -1;
      m.storage = fanStorage<StorageOf<FanOf<Deviatoric<Single>>>>(fans, first_row, lame);
      for (Fan& fan : m.fans)
        for (Index& node : fan.nodes) node += first_row;
      for (Tetrahedron& cell : m.cells)
        for (Index& node : cell) node += first_row;
      m.average(bulk, volume);
    }
    return std::make_unique<NodalDilatation<Single>>(std::move(all));
  }
  std::unique_ptr<ElementKernels> makeFans(Index first_row, const LameOf& lame) const {
    using namespace tetrahedron;
    const auto make = [&]<class Single>() -> std::unique_ptr<ElementKernels> {
      const std::vector<Fan> fans = gatherFans(mesh_->tetrahedra, rest_->size());
      return std::make_unique<ModelKernels<FanOf<Single>>>(fanStorage<StorageOf<FanOf<Single>>>(fans, first_row, lame));
    };
    if (variant_.method == ElasticMethod::green) return make.template operator()<Green>();
    if (variant_.method == ElasticMethod::small)
      return variant_.mean_dilatation ? makeAveraged<Linear>(first_row, lame) : make.template operator()<Linear>();
    return makeRotated(variant_, [&]<class Rotation, Update update>() -> std::unique_ptr<ElementKernels> {
      if (variant_.exact_tangent) return make.template operator()<ExactCorotational<Rotation, update>>();
      if (variant_.mean_dilatation) return makeAveraged<Corotational<Rotation, update>>(first_row, lame);
      return make.template operator()<Corotational<Rotation, update>>();
    });
  }

  static Mat3 edgesOf(const Tetrahedron& t, auto&& position) {
    const Vec3 a = position(t[0]);
    Mat3 edges;
    edges << position(t[1]) - a, position(t[2]) - a, position(t[3]) - a;
    return edges;
  }
  Mat3 restEdges(const Tetrahedron& t) const {
    return edgesOf(t, [&](Index n) -> Vec3 { return (*rest_)[n]; });
  }
  Mat3 deformationGradient(std::size_t e, ConstRows x) const {
    const Tetrahedron& t = mesh_->tetrahedra[e];
    return edgesOf(t, [&](Index n) -> Vec3 { return x[n]; }) * restEdges(t).inverse();
  }
  /// The frame in which the rest shape is stored: first edge on x, second in the xy plane. Columns are its axes.
  Mat3 restFrame(std::size_t e) const {
    const Mat3 edges = restEdges(mesh_->tetrahedra[e]);
    return toEigen(rotation::gramSchmidt(fromEigen(edges / edges.norm())));
  }
  /// The volume [m^3]; cells that cover the body twice share it.
  double weight(const Mat3& edges) const { return std::abs(edges.determinant()) / (6 * mesh_->overlap); }
  /// Cell e with its vertices in the order of `nodes`, in the frame that the order of the cell gives: method large
  /// depends on it.
  void setElement(std::size_t e, const Tetrahedron& nodes, bool padding, const LameOf& lame, auto& rest,
                  auto& tangent) const {
    const Mat3 axes = restFrame(e), edges = restEdges(nodes), inverse = edges.inverse();
    const M3<double> own = fromEigen((inverse * axes).transpose()), world = fromEigen(inverse.transpose());
    const double volume = padding ? 0 : weight(edges);  // a padding lane has no stiffness
    if constexpr (requires { rest.root; }) rest.root = std::sqrt(lame(e).mu * volume);
    if constexpr (requires { rest.g; }) rest.g = {own.c0, own.c1, own.c2};
    if constexpr (requires { rest.edges; }) {
      const M3<double> local = fromEigen(axes.transpose() * edges);
      rest.edges[0] = local.c0, rest.edges[1] = local.c1, rest.edges[2] = local.c2;
    }
    if constexpr (requires { rest.inverse_six_volume; }) rest.inverse_six_volume = 1 / edges.determinant();
    setTangent(tangent, {world.c0, world.c1, world.c2}, lame(e), volume);
  }

  const Mesh* mesh_ = nullptr;
  const std::vector<Vec3>* rest_ = nullptr;
  ElasticVariant variant_;
};

}  // namespace

STROMA_COMPONENT(tetrahedron_fem_force_field) {
  offerElasticKind({"Tetrahedron", "tetrahedra",
                    []() -> std::unique_ptr<ElasticElements> { return std::make_unique<Tetrahedra>(); }});
  using Field = ElasticForceField;
  const std::string help = "linear tetrahedra: corotational (large, polar, svd, nodal), small strains, Green-Lagrange";
  const auto here = [](Field& f) { f.kinds = {"Tetrahedron"}; };
  factory.add<Field>("TetrahedronFEMForceField", help, here);
  factory.add<Field>("TetrahedralCorotationalFEMForceField", help, here);
  factory.add<Field>("FastTetrahedralCorotationalForceField", help,
                     [](Field& f) { f.kinds = {"Tetrahedron"}, f.method_word = Field::Word::qr; });
}
