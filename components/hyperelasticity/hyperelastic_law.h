// SPDX-License-Identifier: LGPL-2.1-or-later
// A hyperelastic law as a scene names it: parameters and kernels. A law's .cpp makes it by lawOf<TheLaw>(...) of
// hyperelastic_kernels.h and offers it once, by offerHyperelasticLaw(); a module outside the tree can offer more.
#pragma once
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "framework/fem/element_kernels.h"
#include "framework/fem/isotropic.h"
#include "framework/mesh/mesh.h"

namespace stroma::hyperelastic {

/// Parameters are positional (the order of ParameterSet), and attributes by name.
struct ParameterInfo {
  std::string name, unit, help;
  bool positive = false;  ///< must be above zero
};

/// Numbers in the order of HyperelasticLaw::parameters.
using Values = std::span<const double>;

/// How the law is used; chosen once.
enum class Form : int { mjed, regularised, projected, standard };

/// What a law is built on: cells, rest shape, and for each cell its parameters and the axes of its material.
struct Cells {
  const Mesh* mesh;
  const std::vector<Vec3>* rest;
  Index first_row;
  /// Of each cell; they stay where they are as long as the kernels live, which may read them there.
  std::function<Values(std::size_t)> parameters;
  std::function<Mat3(std::size_t)> axes;  ///< columns: fibre, sheet, normal
  Form form;
};

/// A law at a point, of point_functions.h.
struct PointFunctions;

/// U(J) of a part k U(J) of an energy, k a parameter: what makes a body incompressible as k grows.
enum class VolumePart : int {
  none,              ///< the energy has none
  half_log_squared,  ///< (ln J)^2/2
  half_square,       ///< (J - 1)^2/2
  log_integral       ///< J ln J - J + 1
};

struct HyperelasticLaw {
  std::string name;     ///< materialName
  std::string formula;  ///< the energy, for the manual
  std::vector<ParameterInfo> parameters;
  int directions = 0;             ///< of AnisotropyDirections: 0, 1 (fibre) or 3 (fibre, sheet, normal)
  bool infinite_at_zero = false;  ///< the energy is infinite at J = 0 and has no value below
  bool curved_in_volume = true;   ///< d2W/dJ2 is not zero whatever F; by the kernels
  VolumePart volume = VolumePart::none;
  std::size_t volume_parameter = 0;  ///< k of volume; with k = 0 the rest of the energy remains
  /// Fills the parameters that are not given (NaN) so that small strains follow Lame's constants; returns what is
  /// missing for that as a sentence, or empty. Null: the law has no such conversion.
  std::function<std::string(const Lame&, std::vector<double>&)> from_lame;
  /// Refuses parameters that have no meaning together: a sentence, or empty.
  std::function<std::string(Values)> check;
  /// Where the law is a sum of any number of terms: the same with `terms` of them, 1 or more, each with its parameters;
  /// the law itself stands for all and is never used. Null: it is one law.
  HyperelasticLaw (*with_terms)(std::size_t terms) = nullptr;

  /// In the forms mjed and regularised.
  std::unique_ptr<ElementKernels> (*tetrahedra)(const Cells&) = nullptr;
  /// For kernels of other cells and forms; null for a form that they do not have.
  const PointFunctions* (*at_point)(Form) = nullptr;
  /// P [Pa] of F, and dP at F for dF, in the material's axes.
  Mat3 (*stress)(Values parameters, const Mat3& f) = nullptr;
  Mat3 (*differential)(Values parameters, const Mat3& f, const Mat3& df) = nullptr;

  /// Shear modulus across the fibre and bulk modulus [Pa] of small strains: of the kernels, whatever the formula.
  struct Moduli {
    double shear, bulk;
  };
  Moduli moduliAtRest(Values values) const;

  std::string expectation() const;  ///< "2 values: mu [Pa], lambda [Pa]"
  /// Those that a scene can give by name: of a sum of terms the first `named_terms`.
  std::vector<ParameterInfo> namedParameters() const;
  bool takes(const std::string& parameter) const;  ///< one of namedParameters()
  static constexpr std::size_t named_terms = 6;
};

const std::vector<HyperelasticLaw>& hyperelasticLaws();
/// Offering a name again, with as many parameters, changes nothing: a module registers once for each factory, and other
/// threads may be reading.
void offerHyperelasticLaw(HyperelasticLaw law);

/// The law in Lame's constants: they come before its parameters, and give it from_lame and check.
HyperelasticLaw inLameConstants(HyperelasticLaw law);
/// The law with a part k0/2 (ln J)^2: k0 comes after its parameters, is that of `volume`, and the bulk modulus of small
/// strains. `from_shear` fills the others from the shear modulus, as from_lame; null: there is no such conversion.
HyperelasticLaw withBulkModulus(HyperelasticLaw law,
                                std::function<std::string(double mu, std::vector<double>&)> from_shear);

}  // namespace stroma::hyperelastic
