// SPDX-License-Identifier: LGPL-2.1-or-later
// Trilinear hexahedra with eight Gauss points and a rotation taken out of each element: small strains, large
// displacements.
//
// With R the rotation of an element, B its strain-displacement matrix at a Gauss point, w the point's weight and D
// Hooke's law,
//   f = R sum w B^T D B (R^T x - X),      df = R sum w B^T D B R^T dx     (f is the restoring force with a minus sign)
// Source: M. Nesme, M. Marchal, E. Promayon, M. Chabanas, Y. Payan, F. Faure, "Physically realistic interactive
// simulation for biological soft tissues", Recent Research Developments in Biomechanics 2, 2005 (sections 2 to 3, 5.1,
// appendix A). The shape is any isoparametric hexahedron; nodes are in the order of VTK.
//
// R belongs to F = [means of the four edges in each direction, now] [at rest]^-1. method = small: R = I; large: QR
// (first mean edge, plane of the first two); polar: nearest orthogonal matrix, the least stretched axis flipped in an
// inverted element; svd: the smallest inversion (Irving et al. 2004); green: no rotation, St. Venant-Kirchhoff,
//   E = (F^T F - I)/2,   S = lambda tr(E) I + 2 mu E,   f_a = -sum w F S grad N_a,   W = sum w (lambda/2 tr(E)^2 + mu E
//   : E)
// with F at each Gauss point: the nonlinear geometric reference, with a potential and an exact, symmetric tangent.
//
// updateStiffnessMatrix rebuilds B from the current shape at each Gauss point: forces then exert no torque on a body
// (Euler's law), which a constant B does not ensure. updateVolume also updates the determinant in B and in the weight.
// Both have a meaning for large, polar and svd. tangent = exact adds the derivatives of R and B; it is symmetric for
// small and green only, because the rotation of the mean edges minimises no energy: an unsymmetric tangent needs
// SparseLDLSolver.
//
// dilatation = mean takes the volume change as one number per element, its mean at rest weights (Nagtegaal, Parks and
// Rice 1974; the B-bar of Hughes 1980): near nu = 1/2 the element does not lock, and a compressed body does not buckle
// element by element under the pressures of locking. For green it is the mean of tr(E). With updateVolume a point
// counts with the root of its weight times the one at rest.
//
// Cell fields for exporters: vonMises [Pa], J (the smallest of the eight Gauss points), strain (6 per cell: xx yy zz xy
// yz zx, the mean of sym(R^T F) - I for every variant, of E for green, in the axes of the rest shape).
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-8"/>
//   <RegularGridTopology name="grid" n="3 3 9" min="0 0 0" max="0.02 0.02 0.1"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="0.04"/>
//   <HexahedronFEMForceField method="polar" youngModulus="1e5" poissonRatio="0.4"/>
//   <BoxROI name="held" box="-1 -1 -0.001 1 1 0.001"/>
//   <FixedProjectiveConstraint indices="@held.indices"/>
// </Node>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <algorithm>

#include "components/elasticity/elastic_force_field.h"
#include "components/elasticity/elastic_kernels.h"
#include "components/elasticity/hexahedron_models.h"
#include "framework/fem/eigen_matrix.h"
#include "framework/scene/factory.h"

using namespace stroma;
using namespace stroma::hexahedron;

namespace {

/// Shapes that differ from a box by less than this part of their edges are boxes.
constexpr double box_tolerance = 1e-12;

struct RestShape {
  M3<double> frame;          ///< axes of the mean edges in world axes
  Modes<double> modes;       ///< in the frame
  double low = 0, high = 0;  ///< smallest and largest det J_0 at the Gauss points
  bool box = false;
};

class Hexahedra final : public ElasticElements {
 public:
  Index count(const Mesh& mesh) const override { return Index(mesh.hexahedra.size()); }
  bool has(ElasticMethod method) const override { return method != ElasticMethod::nodal; }
  bool hasMeanDilatation(ElasticMethod) const override { return true; }
  bool rotationHasPotential() const override { return false; }

  void bind(const Mesh& mesh, const std::vector<Vec3>& rest, const ElasticVariant& variant) override {
    mesh_ = &mesh, rest_ = &rest, variant_ = variant;
    boxes_ = true;
    for (std::size_t e = 0; e < mesh.hexahedra.size(); ++e) {
      const RestShape shape = restShape(e);
      const double size = std::sqrt(squaredNorm(meanEdges(shape.modes))) / 8;
      const double tiny = 1e-12 * size * size * size;
      if (!(shape.low > tiny || shape.high < -tiny))
        throw ComponentError(
            fmt::format("{} is flat or folded at rest: its volume ratio goes from {:.3g} to {:.3g}", describe(e),
                        shape.low / (size * size * size), shape.high / (size * size * size)),
            "a volume whose corners are all on the right side");
      boxes_ = boxes_ && shape.box;
    }
  }

  std::unique_ptr<ElementKernels> make(Index first_row, const std::function<Lame(std::size_t)>& lame) const override {
    return withOwnMatrix(variant_, makeMethod(first_row, lame));
  }

  std::string describe(std::size_t e) const override {
    return fmt::format("hexahedron {} (nodes {})", e, fmt::join(mesh_->hexahedra[e], " "));
  }
  double jacobian(std::size_t e, ConstRows x) const override {
    const PointValues<double> now = atPoints(currentModes(e, x)), rest = atPoints(restShape(e).modes);
    double least = std::numeric_limits<double>::infinity();
    for (int p = 0; p < 8; ++p) {
      const double j = determinant(now, p) / determinant(rest, p);
      if (!(j >= least)) least = j;  // a NaN stays
      if (least != least) break;
    }
    return least;
  }
  Mat3 strain(std::size_t e, ConstRows x) const override {
    Mat3 sum = Mat3::Zero();
    double volume = 0;
    forEachStrain(e, x, [&](const Mat3& here, double weight) {
      sum += weight * here;
      volume += weight;
    });
    return sum / volume;
  }
  double strainBeyond(double limit, std::size_t e, ConstRows x) const override {
    double worst = 0;
    forEachStrain(e, x, [&](const Mat3& here, double) {
      worst = std::max(worst, principalBeyond(limit, here, variant_.method == ElasticMethod::green));
    });
    return worst;
  }
  Nanoseconds cost() const override {
    const double lanes = 8. / pack_lanes;
    const bool green = variant_.method == ElasticMethod::green;
    return {(green ? 60 : variant_.exact_tangent ? 150 : usesBoxes() ? 12 : 25) * lanes, 1200};
  }

 private:
  /// use(strain, volume) at the integration points.
  template <class Use>
  void forEachStrain(std::size_t e, ConstRows x, Use&& use) const {
    const RestShape shape = restShape(e);
    const Modes<double> m = currentModes(e, x);
    const PointValues<double> now = atPoints(m), rest = atPoints(shape.modes);
    const Mat3 frame = toEigen(shape.frame);
    const Mat3 r = rotationOf(toEigen(meanEdges(m)) * toEigen(meanEdges(shape.modes)).inverse(), frame);
    for (int p = 0; p < 8; ++p) {
      const Mat3 j0 = toEigen(Columns<double>(rest, p).matrix());
      const Mat3 f = toEigen(Columns<double>(now, p).matrix()) * j0.inverse() * frame.transpose();
      const Mat3 turned = frame * r.transpose() * f;
      use(variant_.method == ElasticMethod::green ? Mat3((f.transpose() * f - Mat3::Identity()) / 2)
                                                  : Mat3((turned + turned.transpose()) / 2 - Mat3::Identity()),
          std::abs(j0.determinant()));
    }
  }

  /// Boxes have a kernel of their own where B is constant.
  bool usesBoxes() const {
    const bool small = variant_.method == ElasticMethod::small, green = variant_.method == ElasticMethod::green;
    return boxes_ && variant_.update == Update::none && (small || green || !variant_.exact_tangent);
  }

  std::unique_ptr<ElementKernels> makeMethod(Index first_row, const std::function<Lame(std::size_t)>& lame) const {
    const ElasticMethod method = variant_.method;
    if (usesBoxes()) {
      if (method == ElasticMethod::green) return makeGreen<BoxShape>(first_row, lame);
      if (method == ElasticMethod::small) return fill<BoxLinear>(first_row, lame);
      if (method == ElasticMethod::large) return fill<BoxCorotational<rotation::Qr>>(first_row, lame);
      if (method == ElasticMethod::polar) return fill<BoxCorotational<rotation::Polar>>(first_row, lame);
      return fill<BoxCorotational<rotation::Svd>>(first_row, lame);
    }
    if (method == ElasticMethod::green) return makeGreen<PointShape>(first_row, lame);
    if (variant_.mean_dilatation) return makePoints<MeanDilatation>(first_row, lame);
    return makePoints<LocalDilatation>(first_row, lame);
  }
  template <class Shape>
  std::unique_ptr<ElementKernels> makeGreen(Index first_row, const std::function<Lame(std::size_t)>& lame) const {
    if (variant_.mean_dilatation) return fill<Green<Shape, true>>(first_row, lame);
    return fill<Green<Shape, false>>(first_row, lame);
  }
  template <template <class> class Law>
  std::unique_ptr<ElementKernels> makePoints(Index first_row, const std::function<Lame(std::size_t)>& lame) const {
    if (variant_.method == ElasticMethod::small) return fill<PointLinear<Law>>(first_row, lame);
    return makeRotated(variant_, [&]<class Rotation, Update update>() -> std::unique_ptr<ElementKernels> {
      if constexpr (std::is_same_v<Law<double>, LocalDilatation<double>>)
        if (variant_.exact_tangent) return fill<ExactPointCorotational<Rotation, update>>(first_row, lame);
      return fill<PointCorotational<Law, Rotation, update>>(first_row, lame);
    });
  }
  template <class Model>
  std::unique_ptr<ElementKernels> fill(Index first_row, const std::function<Lame(std::size_t)>& lame) const {
    return std::make_unique<ModelKernels<Model>>(filled<StorageOf<Model>>(first_row, lame));
  }
  template <class Storage>
  [[gnu::noinline]] Storage filled(Index first_row, const std::function<Lame(std::size_t)>& lame) const {
    Storage storage;
    storage.build(mesh_->hexahedra, *rest_, first_row, [&](std::size_t e, bool padding, auto& rest, auto& tangent) {
      // cells that cover the body twice share its stiffness; a padding lane has none
      const double share = padding ? 0 : 1 / mesh_->overlap;
      const Lame constants{lame(e).lambda * share, lame(e).mu * share};
      set(restShape(e), constants, rest, tangent);
    });
    return storage;
  }

  void set(const RestShape& shape, const Lame& constants, BoxRest<double>& rest, BoxTangent<double>& tangent) const {
    const double edges[3] = {shape.modes.xi.x, shape.modes.eta.y, shape.modes.zeta.z};
    for (int i = 0; i < 3; ++i) rest.edges[i] = edges[i], tangent.stiffness.inverse[i] = 8 / edges[i];
    tangent.axes = shape.frame;
    const double weight = std::abs(shape.low);
    BoxStiffness<double>& s = tangent.stiffness;
    s.lambda = constants.lambda * weight / 8, s.mu = constants.mu * weight / 8;
    s.varying = variant_.mean_dilatation ? -2. / 3 * s.mu : s.lambda;
  }
  void set(const RestShape& shape, const Lame& constants, BoxRest<double>&, BoxShape::Tangent<double>& tangent) const {
    const double edges[3] = {shape.modes.xi.x, shape.modes.eta.y, shape.modes.zeta.z}, weight = std::abs(shape.low);
    for (int i = 0; i < 3; ++i) tangent.gradient[i] = std::sqrt(weight) / edges[i];
    tangent.inverse_weight = 1 / weight;
    setGreen(shape, constants, tangent);
  }
  /// In the frame of the mean edges, but world axes for method small, which turns nothing.
  void set(const RestShape& shape, const Lame& constants, PointRest<double>& rest, auto& tangent) const {
    if constexpr (requires { tangent.law; })
      setLaw(shape, constants, tangent.law);
    else
      setGreen(shape, constants, tangent);
    const bool turned = variant_.method != ElasticMethod::small;
    rest.modes = turned ? shape.modes : rotated(shape.frame, shape.modes);
    const Mat3 inverse = toEigen(meanEdges(rest.modes)).inverse();
    const int row[6] = {0, 0, 1, 0, 1, 2}, column[6] = {0, 1, 1, 2, 2, 2};
    for (int i = 0; i < 6; ++i) rest.inverse_edges[i] = inverse(row[i], column[i]);
    const PointValues<double> j = atPoints(rest.modes);
    for (int p = 0; p < 8; ++p) {
      const M3<double> columns = Columns<double>(j, p).matrix(), n = cofactor(columns);
      rest.inverse_determinant[p] = 1 / determinant(j, p);
      const double weight = std::abs(determinant(j, p)) / 512;
      rest.scale[p] = std::copysign(1 / (512 * std::sqrt(weight)), determinant(j, p));
      rest.g[p] = {n.c0 * rest.scale[p], n.c1 * rest.scale[p], n.c2 * rest.scale[p]};
      if constexpr (requires { tangent.g; })
        tangent.g[p] = turned ? elastic::rotated(shape.frame, rest.g[p]) : rest.g[p];
    }
  }

  static void setLaw(const RestShape&, const Lame& constants, LocalDilatation<double>& law) {
    law = {constants.lambda, constants.mu};
  }
  static void setLaw(const RestShape& shape, const Lame& constants, MeanDilatation<double>& law) {
    law.lambda = -2. / 3 * constants.mu, law.mu = constants.mu;
    law.bulk = (constants.lambda + 2. / 3 * constants.mu) / volume(shape);
    const PointValues<double> j = atPoints(shape.modes);
    for (int p = 0; p < 8; ++p) law.root[p] = std::sqrt(std::abs(determinant(j, p)) / 512);
  }
  void setGreen(const RestShape& shape, const Lame& constants, auto& tangent) const {
    const bool mean = variant_.mean_dilatation;
    tangent.lambda = mean ? -2. / 3 * constants.mu : constants.lambda, tangent.mu = constants.mu;
    tangent.bulk = mean ? (constants.lambda + 2. / 3 * constants.mu) / volume(shape) : 0;
  }

  static double volume(const RestShape& shape) {
    const PointValues<double> j = atPoints(shape.modes);
    double sum = 0;
    for (int p = 0; p < 8; ++p) sum += std::abs(determinant(j, p)) / 512;
    return sum;
  }
  static double determinant(const PointValues<double>& j, int p) {
    const Columns<double> c(j, p);
    return stroma::dot(c.d[0], cross(c.d[1], c.d[2]));
  }
  Modes<double> currentModes(std::size_t e, ConstRows x) const {
    V3<double> corner[8];
    for (int a = 0; a < 8; ++a) corner[a] = vectorOf(x[mesh_->hexahedra[e][a]]);
    return modesOf(corner);
  }
  RestShape restShape(std::size_t e) const {
    V3<double> corner[8];
    for (int a = 0; a < 8; ++a) corner[a] = vectorOf((*rest_)[mesh_->hexahedra[e][a]]);
    const Modes<double> world = modesOf(corner);
    const double size = std::sqrt(squaredNorm(meanEdges(world)));
    RestShape shape;
    shape.frame = rotation::gramSchmidt(meanEdges(world) * (1 / size));
    shape.modes = rotatedBack(shape.frame, world);
    Modes<double> rest_of_box = shape.modes;
    rest_of_box.xi.x = rest_of_box.eta.y = rest_of_box.zeta.z = 0;
    shape.box = dot(rest_of_box, rest_of_box) < box_tolerance * box_tolerance * size * size;
    // the lower triangle of the mean edges is zero up to rounding: make it zero
    shape.modes.xi.y = shape.modes.xi.z = shape.modes.eta.z = 0;
    const PointValues<double> j = atPoints(shape.modes);
    shape.low = std::numeric_limits<double>::infinity(), shape.high = -shape.low;
    for (int p = 0; p < 8; ++p) {
      const double value = determinant(j, p) / 512;
      shape.low = std::min(shape.low, value), shape.high = std::max(shape.high, value);
    }
    return shape;
  }
  /// R of the mean edges for F from the frame to the world; the frame itself where nothing is turned.
  Mat3 rotationOf(const Mat3& f, const Mat3& frame) const {
    switch (variant_.method) {
      case ElasticMethod::large:
        return toEigen(rotation::Qr::of(fromEigen(f)));
      case ElasticMethod::polar:
        return toEigen(rotation::Polar::of(fromEigen(f)));
      case ElasticMethod::svd:
        return toEigen(rotation::Svd::of(fromEigen(f)));
      default:
        return frame;
    }
  }

  const Mesh* mesh_ = nullptr;
  const std::vector<Vec3>* rest_ = nullptr;
  ElasticVariant variant_;
  bool boxes_ = false;
};

}  // namespace

STROMA_COMPONENT(hexahedron_fem_force_field) {
  offerElasticKind(
      {"Hexahedron", "hexahedra", []() -> std::unique_ptr<ElasticElements> { return std::make_unique<Hexahedra>(); }});
  factory.add<ElasticForceField>("HexahedronFEMForceField",
                                 "trilinear hexahedra: corotational (large, polar, svd), small strains, Green-Lagrange",
                                 [](ElasticForceField& f) { f.kinds = {"Hexahedron"}; });
}
