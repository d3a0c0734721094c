// SPDX-License-Identifier: LGPL-2.1-or-later
// The tetrahedra of TetrahedronFEMForceField, whose page says what is computed, and of CorotationalFEMForceField.
#include "components/elasticity/elastic_elements.h"
#include "components/elasticity/nodal_dilatation.h"

using namespace stroma;
using namespace stroma::tetrahedron;

namespace {

/// a b^T
template <class T>
M3<T> timesTransposed(const M3<T>& a, const M3<T>& b) {
  return {fma(b.c0.x, a.c0, fma(b.c1.x, a.c1, a.c2 * b.c2.x)), fma(b.c0.y, a.c0, fma(b.c1.y, a.c1, a.c2 * b.c2.y)),
          fma(b.c0.z, a.c0, fma(b.c1.z, a.c1, a.c2 * b.c2.z))};
}

/// method = polar with polarOf = edges, as in SOFA: with the edges D_s now and D_m at rest, R = polar(D_s) polar(D_m)^T.
/// It depends on which node is the first of a cell. Nothing is flipped: R of a cell that has turned inside out is a reflection,
/// and the cell comes to rest in its mirror image.
struct OfEdges {
  template <class T>
  using Rest = RestShape<T>;
  template <class T>
  static M3<T> of(const M3<T>& now, const M3<T>& then) {
    return timesTransposed(rotation::orthogonalFactor(now), rotation::orthogonalFactor(then));
  }
};

/// A rest shape that is stored in the axes of the scene.
template <class T>
struct WorldRestShape : RestShape<T> {};

/// method = svd with polarOf = edges, as in SOFA: the same until a cell has less than a millionth of its volume or is inside out. Then
/// R = P nearest(D_m^-1 D_s) P^T, P = polar(D_m), with the nearest rotation, all in the axes of the scene.
struct NearestOfEdges {
  template <class T>
  using Rest = WorldRestShape<T>;
  template <class T>
  static M3<T> of(const M3<T>& now, const M3<T>& then) {
    const M3<T> p = rotation::orthogonalFactor(then), c = cofactor(then);
    const T inverse = T(1.) / dot(then.c0, c.c0);
    const M3<T> r = timesTransposed(rotation::orthogonalFactor(now), p);
    const auto inside_out = dot(now.c0, cross(now.c1, now.c2)) * inverse < T(1e-6);
    if (!any(inside_out)) return r;
    const auto solved = [&](const V3<T>& e) { return V3<T>{dot(c.c0, e), dot(c.c1, e), dot(c.c2, e)} * inverse; };
    const M3<T> n = rotation::nearest(M3<T>{solved(now.c0), solved(now.c1), solved(now.c2)});
    return select(inside_out, timesTransposed(p * n, p), r);
  }
};

/// polarOf = nodes, as in SOFA's CorotationalFEMForceField: R = polar(sum (x_a - c)(X_a - C)^T) = polar(D_s W^T), where W has the
/// edges at rest less a quarter of their sum. A reflection where the cell is inside out, but the nearest rotation for method = svd.
template <bool nearest>
struct OfNodes {
  template <class T>
  using Rest = RestShape<T>;
  template <class T>
  static M3<T> of(const M3<T>& now, const M3<T>& then) {
    const V3<T> centre = (then.c0 + then.c1 + then.c2) * T(0.25);
    const M3<T> sum = timesTransposed(now, M3<T>{then.c0 - centre, then.c1 - centre, then.c2 - centre});
    return nearest ? rotation::nearest(sum) : rotation::orthogonalFactor(sum);
  }
};

template <class Rotation>
struct RestEdgePolar : ByStrain<RestEdgePolar<Rotation>> {
  template <class T>
  using Rest = typename Rotation::template Rest<T>;
  template <class T>
  static S3<T> strain(const Rest<T>& rest, auto& t, const V3<T> (&x)[4]) {
    const Edges<T> edges(x);
    const M3<T> r = Rotation::of(M3<T>{edges.e[0], edges.e[1], edges.e[2]}, M3<T>{rest.edges[0], rest.edges[1], rest.edges[2]});
    const Gradients<T> g = rotated(r, rest.g);
    t.g = {g.g1 * rest.root, g.g2 * rest.root, g.g3 * rest.root};
    return strainOfKinematics<Update::none>(edges.e, t.g, rest.root);
  }
};

class Tetrahedra final : public ElasticElements {
 public:
  Index count(const Mesh& mesh) const override { return Index(mesh.tetrahedra.size()); }
  const CellKind& kind() const override { return cell_kinds::tetrahedron; }
  bool has(ElasticMethod) const override { return true; }
  bool hasMeanDilatation(ElasticMethod method) const override {
    return method != ElasticMethod::green && method != ElasticMethod::nodal;
  }
  // up to here the mean is better by a fifth of the error at most, and a product costs twice as much
  double meanDilatationFrom() const override { return std::nextafter(0.45, 1); }
  std::size_t mostMaterials() const override { return 100; }  // nodal_averages.cpp
  bool rotationHasPotential() const override { return true; }
  bool usePolarOf(PolarOf what) override {
    polar_of_ = what;
    return true;
  }

  void bind(const Mesh& mesh, const std::vector<Vec3>& rest, const ElasticVariant& variant) override {
    variant_ = variant;
    shapes_ = std::make_unique<TetrahedronShapes>(mesh, rest, variant.update);
  }

  std::unique_ptr<ElementKernels> make(Index first_row, const LameOf& lame) const override {
    return withOwnMatrix(variant_, makeMethod({*shapes_, first_row, lame}));
  }

  bool tangentsLieAlike() const override { return !variant_.mean_dilatation; }  // in the same fans

  std::string describe(std::size_t e) const override { return shapes_->describe(e); }
  double jacobian(std::size_t e, ConstRows x) const override {
    return shapes_->deformationGradient(e, x).determinant();
  }
  Mat3 strain(std::size_t e, ConstRows x) const override { return strainOf(e, x).first; }
  void forEachPoint(std::size_t e, ConstRows x, const UseOfPoint& use) const override {
    const auto [strain, carrier] = strainOf(e, x);
    use(strain, carrier, shapes_->weight(shapes_->restEdges(shapes_->mesh().tetrahedra[e])));
  }
  double strainBeyond(double limit, std::size_t e, ConstRows x) const override {
    return principalBeyond(limit, strain(e, x), variant_.method == ElasticMethod::green);
  }
  Nanoseconds cost() const override {
    const double lanes = 8. / pack_lanes;
    const bool green = variant_.method == ElasticMethod::green, nodal = variant_.method == ElasticMethod::nodal;
    const bool by_products = variant_.exact_tangent && !green;  // a matrix of twelve products
    const bool averaged = variant_.mean_dilatation;  // second neighbours
    return {(green ? 12 : by_products ? 40 : nodal ? 30 : averaged ? 12 : 5) * lanes,
            (by_products ? 300 : nodal ? 100 : averaged ? 600 : 45) * lanes};
  }

 private:
  /// With its carrier, see forEachPoint().
  std::pair<Mat3, Mat3> strainOf(std::size_t e, ConstRows x) const {
    const Mat3 f = shapes_->deformationGradient(e, x);
    if (variant_.method == ElasticMethod::small) return {(f + f.transpose()) / 2 - Mat3::Identity(), Mat3::Identity()};
    if (variant_.method == ElasticMethod::green) return {(f.transpose() * f - Mat3::Identity()) / 2, f};
    const Mat3 frame = shapes_->restFrame(e);
    const M3<double> local = fromEigen(f * frame);
    const M3<double> r = variant_.method == ElasticMethod::large   ? rotation::Qr::of(local)
                         : variant_.method == ElasticMethod::polar ? rotation::Polar::of(local)
                                                                   : rotation::Svd::of(local);
    return {frame * (toEigen(rotation::stretch(r, local)) - Mat3::Identity()) * frame.transpose(),
            toEigen(r) * frame.transpose()};
  }
  std::unique_ptr<ElementKernels> makeMethod(const Elements& elements) const {
    if (variant_.method == ElasticMethod::nodal) return oneByOne<NodalWarping, StorageOf<NodalModel>>(elements);
    const bool svd = variant_.method == ElasticMethod::svd;
    if (polar_of_ == PolarOf::edges)
      return svd ? polarKernels<RestEdgePolar<NearestOfEdges>>(elements) : polarKernels<RestEdgePolar<OfEdges>>(elements);
    if (polar_of_ == PolarOf::nodes)
      return svd ? polarKernels<RestEdgePolar<OfNodes<true>>>(elements) : polarKernels<RestEdgePolar<OfNodes<false>>>(elements);
    if (variant_.method == ElasticMethod::green) return kernelsOf<Green>(elements);
    if (variant_.method == ElasticMethod::small)
      return variant_.mean_dilatation ? averagedKernelsOf<Deviatoric<Linear>>(elements) : kernelsOf<Linear>(elements);
    return makeRotated(variant_, [&]<class Rotation>() {
      return variant_.mean_dilatation ? averagedKernels<Rotation>(variant_, elements)
                                      : rotatedKernels<Rotation>(variant_, elements);
    });
  }
  template <class Model>
  static std::unique_ptr<ElementKernels> polarKernels(const Elements& elements) {
    return oneByOne<ModelKernels<Model>, StorageOf<Model>>(elements);
  }
  /// Not in fans, which change the order of the nodes of a cell.
  template <class Kernels, class Storage>
  static std::unique_ptr<ElementKernels> oneByOne(const Elements& elements) {
    const auto fill = [&shapes = elements.shapes, lame = elements.lame](Storage& stored) { fillOneByOne(stored, shapes, lame); };
    Storage storage;
    storage.arrange(elements.shapes.mesh().tetrahedra, elements.shapes.positions(), elements.first_row);
    fill(storage);
    return std::make_unique<Kernels>(std::move(storage), fill);
  }
  template <class Storage>
  static void fillOneByOne(Storage& storage, const TetrahedronShapes& shapes, const LameOf& lame) {
    const std::vector<Tetrahedron>& cells = shapes.mesh().tetrahedra;
    storage.fill([&](std::size_t e, bool padding, auto& rest, auto& tangent) {
      shapes.set(e, cells[e], padding, lame, rest, tangent);
      if constexpr (std::is_same_v<decltype(rest), WorldRestShape<double>&>) {
        const M3<double> axes = fromEigen(shapes.restFrame(e));
        rest.g = rotated(axes, rest.g);
        for (V3<double>& edge : rest.edges) edge = axes * edge;
      }
    });
  }

  ElasticVariant variant_;
  PolarOf polar_of_ = PolarOf::gradient;
  std::unique_ptr<TetrahedronShapes> shapes_;
};

}  // namespace

std::unique_ptr<ElasticElements> stroma::makeTetrahedra() { return std::make_unique<Tetrahedra>(); }
