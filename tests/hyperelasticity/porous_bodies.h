// SPDX-License-Identifier: LGPL-2.1-or-later
// Bodies with a fluid, of tetrahedra and of hexahedra: one cell, an irregular body, Terzaghi's column.
#pragma once
#include <numbers>
#include <regex>

#include "framework/mechanics/history.h"
#include "framework/mesh/cell_kind.h"
#include "framework/mesh/topology.h"
#include "tests/hyperelasticity/law_cases.h"

namespace stroma::test {

/// A kind of cell that may hold a fluid.
struct PorousKind {
  std::string name, field, elastic;
  const CellKind& cell;
  Vec3 gradient;  ///< int grad N_1 dV of oneCell()
  bool isTetrahedra() const { return cell.type == CellType::tetrahedron; }

  /// The unit tetrahedron or cube, with the fluid alone.
  std::string oneCell(const std::string& attributes) const {
    return "<Node name=\"root\" dt=\"0.01\"><EulerImplicitSolver/><CGLinearSolver/>" +
           std::string(isTetrahedra() ? "<TetrahedronSetTopologyContainer position=\"0 0 0 1 0 0 0 1 0 0 0 1\" "
                                        "tetrahedra=\"0 1 2 3\"/>"
                                      : "<HexahedronSetTopologyContainer position=\"0 0 0 1 0 0 1 1 0 0 1 0  0 0 1 "
                                        "1 0 1 1 1 1 0 1 1\" hexahedra=\"0 1 2 3 4 5 6 7\"/>") +
           "<MechanicalObject/><UniformMass totalMass=\"1\"/><" + field +
           " fluidFraction=\"0.8\" bulkModulus=\"400\" limitModulus=\"2200\" " + attributes + "/></Node>";
  }
  /// The organ, or a block of which every node has moved by up to a fifth of an edge; with the fluid alone.
  std::string body(const std::string& attributes) const {
    const std::string fluid = "fluidFraction=\"0.5\" bulkModulus=\"400\" limitModulus=\"2200\" " + attributes;
    if (isTetrahedra()) return lawScene(fluid, field);
    return std::regex_replace(hexahedraScene("", false), std::regex("<HexahedronFEMForceField[^>]*>"),
                              "<" + field + " " + fluid + "/>");
  }
};

inline const std::vector<PorousKind>& porousKinds() {
  static const std::vector<PorousKind> kinds{
      {"tetrahedra", "TetrahedronPorousForceField", tetrahedral, cell_kinds::tetrahedron, Vec3(1, 0, 0) / 6},
      {"hexahedra", "HexahedronPorousForceField", "HexahedronHyperelasticityFEMForceField", cell_kinds::hexahedron,
       Vec3(1, -1, -1) / 4}};
  return kinds;
}
inline const std::vector<std::string> couplings{"semi_implicit", "implicit"};

/// A number as an attribute, with all its digits.
inline std::string textOf(double v) {
  std::ostringstream out;
  out.precision(17);
  out << v;
  return out.str();
}

/// The only fluid of a simulation.
inline const History& fluidOf(Simulation& s) {
  for (const ForceField* field : s.systems()[0]->forceFields())
    if (field->type().find("Porous") != std::string::npos) return dynamic_cast<const History&>(*field);
  throw std::runtime_error("the scene has no fluid");
}

// ---- Terzaghi ----

/// A column of height 1 between walls, drained at its top, under a pressure on its top. c = 1, so T_v = t. With Biot's
/// alpha and M, after E. Detournay and A. H.-D. Cheng 1993:
///   K_u + 4G/3 = K + 4G/3 + alpha^2 M,   c = kappa M (K + 4G/3)/(K_u + 4G/3),
///   P = load alpha M/(K_u + 4G/3) at once,   settlement from load/(K_u + 4G/3) to load/(K + 4G/3)
struct Column {
  double limit = 2200, elastic = 1000, bulk = 400, load = 0.1;
  double alpha = 1, biot_modulus = 0;  ///< 0: limit
  std::string coupling = "implicit";
  int cells = 20, across = 2;  ///< cells along it; nodes across it
  double dt = 0.001;
  const PorousKind* kind = &porousKinds()[0];
  double modulus() const { return biot_modulus > 0 ? biot_modulus : limit; }
  double drained() const { return elastic + bulk; }  ///< K + 4G/3
  double undrained() const { return drained() + alpha * alpha * modulus(); }
  double permeability() const { return undrained() / (modulus() * drained()); }
  double firstPressure() const { return load * alpha * modulus() / undrained(); }
  std::string mesh() const {
    const std::string grid = "<RegularGridTopology name=\"grid\" n=\"" + std::to_string(across) + " " +
                             std::to_string(across) + " " + std::to_string(cells + 1) +
                             "\" min=\"0 0 0\" max=\"0.2 0.2 1\"/>";
    return kind->isTetrahedra()
               ? grid +
                     "<Node name=\"b\"><TetrahedronSetTopologyContainer name=\"tets\"/>"
                     "<Hexa2TetraTopologicalMapping input=\"@../grid\" output=\"@tets\" cutting=\"ten\"/>"
               : "<Node name=\"b\">" + grid;
  }
  std::string scene() const {
    return "<Node name=\"root\" dt=\"" + textOf(dt) +
           "\" gravity=\"0 0 0\"><StaticSolver newton_iterations=\"200\" "
           "relative_residual_tolerance_threshold=\"1e-7\"/><SparseLDLSolver/>" +
           mesh() + "<MechanicalObject/><UniformMass totalMass=\"1\"/><" + kind->elastic +
           " materialName=\"StVenantKirchhoff\" ParameterSet=\"" + textOf(elastic / 2) + " 0\"/><" + kind->field +
           " fluidFraction=\"" + (alpha < 0.8 ? "0.5" : "0.8") + "\" bulkModulus=\"" + textOf(bulk) +
           "\" limitModulus=\"" + textOf(limit) +
           (alpha < 1 ? "\" biotCoefficient=\"" + textOf(alpha) : std::string()) + "\" biotModulus=\"" +
           textOf(biot_modulus > 0 ? biot_modulus : limit) + "\" permeability=\"" + textOf(permeability()) +
           "\" coupling=\"" + coupling +
           "\" drainedIndices=\"@top.indices\"/><BoxROI name=\"top\" box=\"-1 -1 0.9999 1 1 2\"/>"
           "<BoxROI name=\"base\" box=\"-1 -1 -0.1 1 1 0.0001\"/>"
           "<BoxROI name=\"all\" box=\"-1 -1 -1 1 1 2\"/>"
           "<FixedProjectiveConstraint indices=\"@base.indices\"/>"
           "<PartialFixedProjectiveConstraint indices=\"@all.indices\" fixedDirections=\"1 1 0\"/>"
           "<ConstantForceField indices=\"@top.indices\" totalForce=\"0 0 " +
           textOf(-load * 0.04) + "\"/></Node></Node>";
  }
  /// What the top, of 2 x 2 nodes, has come down.
  static double settlement(Simulation& s) {
    double sum = 0;
    const System& system = *s.systems()[0];
    for (Index i = system.allRows() - 4; i < system.allRows(); ++i) sum += (1 - system.x[i].z()) / 4;
    return sum;
  }
  /// Degree of consolidation at the given times.
  std::vector<double> run(const std::vector<double>& times) const {
    Simulation s = simulationFromText(scene());
    std::vector<double> out;
    const double last = load / drained(), first = load / undrained();
    for (double t : times) {
      while (s.time() < t - 1e-9) {
        const StepReport report = s.step();
        EXPECT_TRUE(!report.diverged && !report.unsolved) << report.reason;
        if (report.diverged || report.unsolved) return out;
      }
      out.push_back((settlement(s) - first) / (last - first));
    }
    return out;
  }
};
/// Terzaghi's series.
inline double consolidation(double t) {
  double sum = 1;
  for (int m = 0; m < 200; ++m) {
    const double k = std::numbers::pi * (2 * m + 1) / 2;
    sum -= 2 / (k * k) * std::exp(-k * k * t);
  }
  return sum;
}

}  // namespace stroma::test
