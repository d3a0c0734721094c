// SPDX-License-Identifier: LGPL-2.1-or-later
// A hyperelastic law as a scene names it: parameters and kernels. A law's .cpp offers it once, by
// offerHyperelasticLaw(lawOf<TheLaw>(...)) of hyperelastic_kernels.h; a module outside the tree can offer more.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "framework/fem/element_method.h"
#include "framework/fem/isotropic.h"
#include "framework/mesh/mesh.h"

namespace stroma::hyperelastic {

/// Parameters are positional (the order of ParameterSet), and attributes by name.
struct ParameterInfo {
  std::string name, unit, help;
  bool positive = false;  ///< must be above zero
};

/// How the law is used; chosen once.
enum class Form : int { mjed, regularised, projected, standard };

/// What a law is built on: cells, rest shape, and for each cell its parameters and the axes of its material.
struct Cells {
  const Mesh* mesh;
  const std::vector<Vec3>* rest;
  Index first_row;
  std::function<const double*(std::size_t)> parameters;  ///< in the order of Law::parameters
  std::function<Mat3(std::size_t)> axes;                 ///< columns: fibre, sheet, normal
  Form form;
};

struct HyperelasticLaw {
  std::string name;     ///< materialName
  std::string formula;  ///< the energy, for the manual
  std::vector<ParameterInfo> parameters;
  int directions = 0;             ///< of AnisotropyDirections: 0, 1 (fibre) or 3 (fibre, sheet, normal)
  bool infinite_at_zero = false;  ///< the energy is infinite at J = 0 and has no value below
  bool curved_in_volume = true;   ///< d2W/dJ2 is not zero whatever F; by the kernels
  /// Fills the parameters that are not given (NaN) so that small strains follow Lame's constants; returns what is
  /// missing for that as a sentence, or empty. Null: the law has no such conversion.
  std::function<std::string(const Lame&, std::vector<double>&)> from_lame;
  /// Refuses parameters that have no meaning together: a sentence, or empty.
  std::function<std::string(const double*)> check;

  std::unique_ptr<ElementMethod> (*tetrahedra)(const Cells&) = nullptr;
  std::unique_ptr<ElementMethod> (*hexahedra)(const Cells&) = nullptr;
  /// P [Pa] of F, and dP at F for dF, in the material's axes.
  Mat3 (*stress)(const double* parameters, const Mat3& f) = nullptr;
  Mat3 (*differential)(const double* parameters, const Mat3& f, const Mat3& df) = nullptr;

  /// Shear modulus across the fibre and bulk modulus [Pa] of small strains: of the kernels, whatever the formula.
  struct Moduli {
    double shear, bulk;
  };
  Moduli moduliAtRest(const double* values) const;

  std::string expectation() const;  ///< "2 values: mu [Pa], lambda [Pa]"
};

const std::vector<HyperelasticLaw>& hyperelasticLaws();
/// A law with more terms is offered under the same name with more parameters. Offering the same again replaces it.
void offerHyperelasticLaw(HyperelasticLaw law);

/// For laws whose parameters are mu and lambda: from_lame and check.
std::string lameParameters(const Lame& lame, std::vector<double>& values);
std::string checkLame(const double* values);

}  // namespace stroma::hyperelastic
