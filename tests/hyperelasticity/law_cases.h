// SPDX-License-Identifier: LGPL-2.1-or-later
// Every law with parameters of a soft tissue, and scenes of it.
#pragma once
#include <string>
#include <vector>

#include "tests/support/field_derivatives.h"

namespace stroma::test {

struct LawCase {
  std::string name;                ///< for messages
  std::string attributes;          ///< materialName and parameters
  double mu, bulk;                 ///< at small strains [Pa]
  bool finite = false;             ///< has an energy at J <= 0
  std::vector<Vec3> directions{};  ///< AnisotropyDirections, orthogonal
  Mat3 axes() const {
    if (directions.empty()) return Mat3::Identity();
    Mat3 axes;
    axes.col(0) = directions[0].normalized();
    axes.col(1) = directions.size() > 1 ? directions[1].normalized() : directions[0].unitOrthogonal();
    axes.col(2) = Vec3(axes.col(0)).cross(Vec3(axes.col(1)));
    return axes;
  }
};

inline const std::vector<LawCase>& lawCases() {
  static const std::vector<LawCase> cases{
      {"StVenantKirchhoff", "materialName=\"StVenantKirchhoff\" ParameterSet=\"1000 4000\"", 1000, 4000 + 2000. / 3,
       true},
      {"NeoHookean", "materialName=\"NeoHookean\" ParameterSet=\"1000 4000\"", 1000, 4000 + 2000. / 3},
      {"MooneyRivlin", "materialName=\"MooneyRivlin\" ParameterSet=\"300 200 5000\"", 1000, 5000},
      {"StableNeoHookean", "materialName=\"StableNeoHookean\" ParameterSet=\"1000 4000\"", 1000, 4000 + 2000. / 3,
       true},
      {"VerondaWestman", "materialName=\"VerondaWestman\" ParameterSet=\"500 2 5000\"", 1000, 5000},
      {"ArrudaBoyce", "materialName=\"ArrudaBoyce\" ParameterSet=\"1000 5000\"", 1085.137, 5000},
      {"Ogden 1", "materialName=\"Ogden\" ParameterSet=\"2000 3.5 5000\"", 1000, 5000},
      {"Ogden 2", "materialName=\"Ogden\" ParameterSet=\"1500 4 500 -2 5000\"", 1000, 5000},
      {"Ogden 3", "materialName=\"Ogden\" ParameterSet=\"1500 1.3 300 5 200 -2 5000\"", 1000, 5000},
      {"Ogden 5", "materialName=\"Ogden\" ParameterSet=\"900 1.3 400 4 300 -2 250 2.5 150 -1 5000\"", 1000, 5000},
      {"Costa",
       "materialName=\"Costa\" ParameterSet=\"500 5000 8 4 2 4 2 3\" AnisotropyDirections=\"1 2 0  2 -1 3\"",
       0,
       0,
       false,
       {Vec3(1, 2, 0), Vec3(2, -1, 3)}},
      {"TransverselyIsotropic",
       "materialName=\"TransverselyIsotropic\" ParameterSet=\"1000 4000 3000 1.5\" AnisotropyDirections=\"1 2 1\"",
       0,
       0,
       false,
       {Vec3(1, 2, 1)}},
      {"Yeoh", "materialName=\"Yeoh\" ParameterSet=\"500 -30 20 5000\"", 1000, 5000},
      {"Hencky", "materialName=\"Hencky\" ParameterSet=\"1000 4000\"", 1000, 4000 + 2000. / 3},
      {"OgdenUnconstrained", "materialName=\"OgdenUnconstrained\" ParameterSet=\"1500 3 500 -2 4000\"", 1000,
       4000 + 2000. / 3},
      {"FungOrthotropic",
       "materialName=\"FungOrthotropic\" ParameterSet=\"5000 3000 2000 1000 700 900 0.3 0.35 0.1 2000 5000\" "
       "AnisotropyDirections=\"1 2 0  2 -1 3\"",
       0,
       0,
       false,
       {Vec3(1, 2, 0), Vec3(2, -1, 3)}},
      {"TransverselyIsotropicMooneyRivlin",
       "materialName=\"TransverselyIsotropicMooneyRivlin\" ParameterSet=\"300 200 150 12 2500 1.06 5000\" "
       "AnisotropyDirections=\"1 2 1\"",
       0,
       0,
       false,
       {Vec3(1, 2, 1)}},
  };
  return cases;
}

const std::string tetrahedral = "TetrahedronHyperelasticityFEMForceField";

/// The organ of the repository under a law.
inline std::string lawScene(const std::string& attributes, const std::string& type = tetrahedral,
                            const std::string& mesh = STROMA_SOURCE_DIR "/scenes/meshes/organ_600.msh") {
  return "<Node name=\"root\" dt=\"0.01\"><Node name=\"body\"><EulerImplicitSolver/><CGLinearSolver/>"
         "<MeshGmshLoader name=\"loader\" filename=\"" +
         mesh +
         "\"/><TetrahedronSetTopologyContainer src=\"@loader\"/><MechanicalObject/><UniformMass totalMass=\"1\"/><" +
         type + " " + attributes + "/></Node></Node>";
}

}  // namespace stroma::test
