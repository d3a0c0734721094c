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
// (first mean edge, plane of the first two), which depends on the order of the nodes, so that elements of one strain
// differ by its square: it fails the patch test by that; polar: nearest orthogonal matrix, the least stretched axis flipped in an
// inverted element, or with polarOf = edges, as in SOFA, R = polar(mean edges now) polar(mean edges at rest)^T, another one unless
// the cell is a cube, or with polarOf = nodes that of sum (x - c)(X - C)^T, of parallelepipeds at rest; svd: the smallest
// inversion (Irving et al. 2004); green: no rotation, St. Venant-Kirchhoff,
//   E = (F^T F - I)/2,   S = lambda tr(E) I + 2 mu E,   f_a = -sum w F S grad N_a,   W = sum w (lambda/2 tr(E)^2 + mu E
//   : E)
// with F at each Gauss point: the nonlinear geometric reference, with a potential and an exact, symmetric tangent.
//
// updateStiffnessMatrix rebuilds B from the current shape at each Gauss point: forces then exert no torque on a body
// (Euler's law), which a constant B does not ensure. updateVolume also updates the determinant in B and in the weight.
// Both have a meaning for large, polar and svd. tangent = exact adds the derivatives of R and B; it is symmetric for
// small and green only, because the rotation of the mean edges minimises no energy: an unsymmetric tangent needs
// SparseLDLSolver, which factors its symmetric part and does the rest by products.
//
// dilatation = auto, the default, is mean where nu is 0.4 or more, and local below. A cantilever with eight cells
// over its height, cells twice as long as high, has 96, 93 and 84 % of Euler's deflection with local at 0.4, 0.45 and 0.49, and 97,
// 97 and 96 % with mean.
// dilatation = mean takes the volume change as one number per element, its mean at rest weights (Nagtegaal, Parks and
// Rice 1974; the B-bar of Hughes 1980): near nu = 1/2 the element does not lock, and a compressed body does not buckle
// element by element under the pressures of locking. For green it is the mean of tr(E). With updateVolume a point
// counts with the root of its weight times the one at rest. Near nu = 1/2 take tangent = exact with it: the pressure
// acts on how the gradients turn, which a warped tangent leaves out, and Newton's method stalls.
//
// incompatibleModes gives each cell nine numbers more, with which it bends: corners alone keep edges straight, so that few cells over
// a height are far too stiff, and flat cells worse. They are condensed out of a cell at rest, K = K_uu - K_ua K_aa^-1 K_au, and
// f = -R K (R^T x - X): hexahedron_incompatible.h has the formulas. Boxes cost what they do without. Source: E. Wilson, R. Taylor, W.
// Doherty, J. Ghaboussi, Incompatible displacement models (1973); R. Taylor, P. Beresford, E. Wilson, A non-conforming element for
// stress analysis (1976), after which cells of any shape pass the patch test. With dilatation = mean they are twelve.
//
// Cell fields for exporters: vonMises [Pa], J (the smallest of the eight Gauss points), strain (6 per cell: xx yy zz xy
// yz zx, the mean of sym(R^T F) - I for every variant, of E for green, in the axes of the rest shape), stress (Cauchy's
// [Pa], six numbers too, in the axes of the world), principalStress and principalStrain (three of a cell, the largest first).
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
#include <algorithm>
#include <optional>

#include "components/elasticity/elastic_force_field.h"
#include "components/elasticity/hexahedron_incompatible.h"
#include "components/elasticity/hexahedron_kernels.h"
#include "components/elasticity/incompatible_modes.h"
#include "components/elasticity/kernels_of_parts.h"
#include "components/elasticity/point_elements.h"
#include "framework/scene/factory.h"

using namespace stroma;
using namespace stroma::hexahedron;

namespace {

class Hexahedra final : public PointElements<Hexahedra>, public HasIncompatibleModes {
 public:
  Index count(const Mesh& mesh) const override { return Index(mesh.hexahedra.size()); }
  const CellKind& kind() const override { return cell_kinds::hexahedron; }
  double meanDilatationFrom() const override { return 0.4; }
  bool rotationHasPotential() const override { return false; }
  bool usePolarOf(PolarOf what) override {
    polar_of_ = what;
    return true;
  }
  void useIncompatibleModes(const LameOf& lame) override { material_of_modes_ = lame; }

  std::unique_ptr<ElementKernels> make(Index first_row, const LameOf& lame) const override {
    return withOwnMatrix(variant_, makeParts(first_row, lame));
  }

  std::string describe(std::size_t e) const override { return shapes_->describe(e); }
  Nanoseconds cost() const override {
    const double lanes = 8. / pack_lanes, boxes = double(shapes_->boxes().size()), others = double(shapes_->others().size());
    const auto product = [this](bool box) {
      if (variant_.method == ElasticMethod::green) return 60.;
      if (material_of_modes_) return box ? (variant_.exact_tangent ? 45. : 18.) : variant_.exact_tangent ? 280. : 130.;
      return variant_.exact_tangent ? 150. : box && boxesAreApart() ? 18. : 44.;
    };
    return {(boxes * product(true) + others * product(false)) / std::max(1., boxes + others) * lanes, 850};
  }

  // ---- for PointElements ----
  void bindShapes(const Mesh& mesh, const std::vector<Vec3>& rest) {
    shapes_ = std::make_unique<HexahedronShapes>(mesh, rest, variant_);
  }
  template <class Use>
  void forEachJacobian(std::size_t e, ConstRows x, Use&& use) const {
    const PointValues<double> now = atPoints(shapes_->now(e, x)), rest = atPoints(shapes_->atRest(e).modes);
    for (int p = 0; p < 8; ++p) use(determinantAt(now, p) / determinantAt(rest, p));
  }
  template <class Use>
  void forEachStrain(std::size_t e, ConstRows x, Use&& use) const {
    const RestShape shape = shapes_->atRest(e);
    const Modes<double> m = shapes_->now(e, x);
    const PointValues<double> now = atPoints(m), rest = atPoints(shape.modes);
    const Mat3 frame = toEigen(shape.frame);
    const Mat3 r = rotationOf(toEigen(meanEdges(m)) * toEigen(meanEdges(shape.modes)).inverse(), frame);
    std::optional<IncompatibleModes> modes;
    IncompatibleModes::Own own;
    if (material_of_modes_) {
      modes.emplace(shape.modes, (*material_of_modes_)(e), variant_.mean_dilatation);
      own = modes->settled(rotatedBack(fromEigen(r), m) - shape.modes);
    }
    for (int p = 0; p < 8; ++p) {
      const Mat3 j0 = toEigen(Columns<double>(rest, p).matrix());
      const Mat3 f = toEigen(Columns<double>(now, p).matrix()) * j0.inverse() * frame.transpose();
      Mat3 turned = frame * r.transpose() * f;
      if (modes) turned += frame * modes->gradient(own, p) * frame.transpose();
      const bool green = variant_.method == ElasticMethod::green;
      use(green ? Mat3((f.transpose() * f - Mat3::Identity()) / 2)
                : Mat3((turned + turned.transpose()) / 2 - Mat3::Identity()),
          green ? f : Mat3(r * frame.transpose()), std::abs(j0.determinant()));
    }
  }

 private:
  /// Boxes have kernels of their own where B is constant.
  bool boxesAreApart() const {
    const bool small = variant_.method == ElasticMethod::small, green = variant_.method == ElasticMethod::green;
    return material_of_modes_ || (variant_.update == Update::none && (small || green || !variant_.exact_tangent));
  }
  std::unique_ptr<ElementKernels> makeParts(Index first_row, const LameOf& lame) const {
    const std::vector<Index>&boxes = shapes_->boxes(), &others = shapes_->others();
    const auto part = [&](bool are_boxes, const std::vector<Index>* chosen) {
      return makeMethod({*shapes_, first_row, lame, are_boxes, chosen});
    };
    if (!boxesAreApart() || boxes.empty() || others.empty()) return part(boxesAreApart() && others.empty(), nullptr);
    return std::make_unique<KernelsOfParts>(part(true, &boxes), part(false, &others));
  }
  std::unique_ptr<ElementKernels> makeMethod(const Elements& elements) const {
    if (material_of_modes_) return incompatibleKernels(elements);
    const bool boxes = elements.boxes;
    if (variant_.method == ElasticMethod::green)
      return boxes ? makeGreen<BoxShape>(elements) : makeGreen<PointShape>(elements);
    if (polar_of_ != PolarOf::gradient) return polarKernels(polar_of_, variant_.method == ElasticMethod::svd, elements);
    if (variant_.mean_dilatation && !boxes) return meanKernels(elements);
    if (variant_.method == ElasticMethod::small)
      return boxes ? kernelsOf<ModalLinear<Boxes>>(elements) : kernelsOf<PointLinear<LocalDilatation>>(elements);
    return makeRotated(variant_, [&]<class Rotation>() { return rotatedKernels<Rotation>(elements); });
  }
  template <class Shape>
  std::unique_ptr<ElementKernels> makeGreen(const Elements& elements) const {
    if (variant_.mean_dilatation) return kernelsOf<GreenModel<Shape, true>>(elements);
    return kernelsOf<GreenModel<Shape, false>>(elements);
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

  PolarOf polar_of_ = PolarOf::gradient;
  std::optional<LameOf> material_of_modes_;  ///< where there are any
  std::unique_ptr<HexahedronShapes> shapes_;
};

}  // namespace

std::unique_ptr<ElasticElements> stroma::makeHexahedra() { return std::make_unique<Hexahedra>(); }

STROMA_COMPONENT(hexahedron_fem_force_field) {
  factory.add<ElasticForceField>("HexahedronFEMForceField",
                                 "trilinear hexahedra: corotational (large, polar, svd), small strains, Green-Lagrange",
                                 [](ElasticForceField& f) { f.kinds = {{"Hexahedron", "hexahedra", makeHexahedra}}; });
}
