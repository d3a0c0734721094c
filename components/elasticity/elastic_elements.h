// SPDX-License-Identifier: LGPL-2.1-or-later
// One kind of element (tetrahedra, hexahedra) as ElasticForceField sees it: which methods it has, what shapes it
// refuses, its kernels and its fields. The registration of a component lists the kinds that it serves.
#pragma once
#include <Eigen/Eigenvalues>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "components/elasticity/elastic_variant.h"
#include "components/elasticity/lame_of.h"
#include "framework/fem/element_kernels.h"
#include "framework/mesh/cell_kind.h"
#include "framework/mesh/mesh.h"

namespace stroma {

/// The cells of one kind of a mesh. Strains are those that the method sees, turned to the axes of the rest shape.
class ElasticElements {
 public:
  virtual ~ElasticElements() = default;
  virtual Index count(const Mesh& mesh) const = 0;
  virtual const CellKind& kind() const = 0;
  virtual bool has(ElasticMethod method) const = 0;
  /// Does a method have ElasticVariant::mean_dilatation?
  virtual bool hasMeanDilatation(ElasticMethod method) const = 0;
  /// The Poisson's ratio from which the mean dilatation is taken where a scene leaves the choice open.
  virtual double meanDilatationFrom() const = 0;
  /// How many bulk moduli the cells may have for a mean dilatation.
  virtual std::size_t mostMaterials() const { return std::numeric_limits<std::size_t>::max(); }
  /// With a constant B: the forces of method svd are the gradient of an energy, so that they exert no torque.
  virtual bool rotationHasPotential() const = 0;
  /// Do large, polar and svd have updateStiffnessMatrix?
  virtual bool updatesStrainDisplacement() const { return true; }
  /// Before bind(): of what method polar takes the factor, other than F. False: it cannot.
  virtual bool usePolarOf(PolarOf) { return false; }

  /// Looks at the rest shapes; throws ComponentError for a cell without a volume. `rest` is kept by reference.
  virtual void bind(const Mesh& mesh, const std::vector<Vec3>& rest, const ElasticVariant& variant) = 0;
  /// `first_row`: row of node 0. What `lame` refers to is to outlive the kernels.
  virtual std::unique_ptr<ElementKernels> make(Index first_row, const LameOf& lame) const = 0;
  /// Kernels of the exact tangent lie as those of the warped one: what is known of the matrix of the one holds for the other.
  virtual bool tangentsLieAlike() const { return false; }
  /// "tetrahedron 12 (nodes 3 4 8 9)"
  virtual std::string describe(std::size_t cell) const = 0;
  /// The smallest det F at the cell's integration points; x starts at node 0.
  virtual double jacobian(std::size_t cell, ConstRows x) const = 0;
  /// The mean strain over the cell.
  virtual Mat3 strain(std::size_t cell, ConstRows x) const = 0;
  /// use(strain, carrier, volume) for each integration point of the cell. With the stress S of that strain, Cauchy's is
  /// A S A^T / det A of the carrier A: the rotation that the method takes out; F where the strain is Green's. The volume is at
  /// rest [m^3], but for a factor of the kind.
  using UseOfPoint = std::function<void(const Mat3& strain, const Mat3& carrier, double volume)>;
  virtual void forEachPoint(std::size_t cell, ConstRows x, const UseOfPoint& use) const = 0;
  /// The size of the largest principal strain at the cell's integration points, or zero where it is below `limit`.
  virtual double strainBeyond(double limit, std::size_t cell, ConstRows x) const = 0;
  /// Nanoseconds of one product and one assembly of a cell, on one core at 2.6 GHz with 8 lanes.
  struct Nanoseconds {
    double product, assembly;
  };
  virtual Nanoseconds cost() const = 0;
};

/// For ElasticElements::strainBeyond(): of one point. `green`: of Green's strain (l^2 - 1) / 2 the strain l - 1.
inline double principalBeyond(double limit, const Mat3& strain, bool green) {
  const double least = green ? limit - limit * limit / 2 : limit;  // of Green's strain where l - 1 = -limit
  if (!(strain.squaredNorm() > least * least)) return 0;           // no principal strain is above the norm
  Vec3 principal = strain.selfadjointView<Eigen::Lower>().eigenvalues();
  if (green) principal = (2 * principal.array() + 1).max(0).sqrt() - 1;
  const double largest = principal.cwiseAbs().maxCoeff();
  return largest > limit ? largest : 0;
}

/// How a kind is called ("Tetrahedron", as in template="Vec3,Tetrahedron") and made.
struct ElasticKind {
  std::string word;    ///< "Tetrahedron"
  std::string plural;  ///< "tetrahedra"
  std::unique_ptr<ElasticElements> (*make)() = nullptr;
  std::unique_ptr<ElasticElements> (*make_reduced)() = nullptr;  ///< with fewer points, where the kind has that
};

std::unique_ptr<ElasticElements> makeTetrahedra();
std::unique_ptr<ElasticElements> makeHexahedra();
std::unique_ptr<ElasticElements> makeQuadraticTetrahedra();
std::unique_ptr<ElasticElements> makePrisms();
std::unique_ptr<ElasticElements> makeReducedPrisms();
std::unique_ptr<ElasticElements> makePyramids();

}  // namespace stroma
