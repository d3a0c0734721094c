// SPDX-License-Identifier: LGPL-2.1-or-later
// What the estimate of mesh_error.cpp needs of a force field: its cells, moduli, and how its law measures volume.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "framework/mechanics/state_positions.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "tools/checks/cells_across.h"
#include "tools/checks/mesh_error.h"
#include "tools/units/unit_system.h"

namespace stroma {
namespace {

/// A list with a value per cell, or empty.
std::vector<double> listOf(const ForceField& field, const char* name, std::size_t cells) {
  const Data* data = field.data().find(name);
  if (!data) return {};
  const auto* list = std::get_if<std::vector<double>*>(&data->pointer());
  return list && (*list)->size() == cells ? **list : std::vector<double>();
}

std::vector<double> modulusOf(const ForceField& field, std::size_t cells) {
  std::vector<double> modulus = listOf(field, "youngModulus", cells);
  const std::vector<double> factor = listOf(field, "localStiffnessFactor", cells);
  if (modulus.empty()) return factor;
  for (std::size_t c = 0; c < factor.size(); ++c) modulus[c] *= factor[c];
  return modulus;
}

/// Of triangles with stiffness in their plane; they have no stress for exporters.
bool isMembrane(const ForceField& field) {
  return field.type().find("Triang") != std::string::npos && field.type().find("FEM") != std::string::npos;
}

/// K/(2 mu), or what stands for it in plane stress; zero where it is not known, and with a mean dilatation for tetrahedra, which have
/// that of their nodes, and hexahedra, which do not lock with it. Prisms and pyramids may.
double bulkOf(const ForceField& field) {
  const Data *data = field.data().find("poissonRatio"), *dilatation = field.data().find("dilatation");
  const bool is_membrane = isMembrane(field);
  const auto* list = data && (dilatation || is_membrane) ? std::get_if<std::vector<double>*>(&data->pointer()) : nullptr;
  if (!list || (*list)->empty()) return 0;
  if (is_membrane) {
    const double nu = *std::max_element((*list)->begin(), (*list)->end());
    return (1 + 2 * nu) / (3 * (1 - nu));
  }
  const CellKind* kind = kindOfLaw(field);
  const bool is_free = kind && (kind->type == CellType::tetrahedron || kind->type == CellType::hexahedron);
  if (is_free && hasMeanDilatation(field)) return 0;
  const double nu = *std::max_element((*list)->begin(), (*list)->end());
  return (1 + nu) / (3 * (1 - 2 * nu));
}

VolumeChange volumeChangeOf(const ForceField& field) {
  using Of = VolumeChange::Of;
  if (!hasMeanDilatation(field) || bulkOf(field) == 0) return {};
  const Data* method = field.data().find("method");
  if (!method) return {field.type().find("SmallStrain") != std::string::npos ? Of::displacement : Of::volume, true};
  const std::string word = method->print();
  if (word == "small" || word == "none" || word == "identity") return {Of::displacement, true};
  return {word.starts_with("green") ? Of::green : Of::stretch, true};
}

/// The cells of a mesh that a field is made of.
template <class Visit>
void visitCells(const ForceField& field, Visit&& visit) {
  const CellKind* kind = kindOfLaw(field);
  const bool is_membrane = isMembrane(field);
  for (const Topology* topology : topologiesOf(field.state())) {
    const Mesh& mesh = topology->mesh();
    if (mesh.overlap != 1 || std::size_t(mesh.nodes()) > field.state().rest_position.size()) continue;
    if (is_membrane && !mesh.triangles.empty()) return visit(mesh.triangles);
    if (is_membrane) continue;
    if (!kind) continue;
    if (kind->type == CellType::tetrahedron && !mesh.tetrahedra.empty()) return visit(mesh.tetrahedra);
    if (kind->type == CellType::hexahedron && !mesh.hexahedra.empty()) return visit(mesh.hexahedra);
    if (kind->type == CellType::prism && !mesh.prisms.empty()) return visit(mesh.prisms);
    if (kind->type == CellType::pyramid && !mesh.pyramids.empty()) return visit(mesh.pyramids);
    if (kind->type == CellType::quadratic_tetrahedron && !mesh.quadratic_tetrahedra.empty()) return visit(mesh.quadratic_tetrahedra);
  }
}

}  // namespace

std::optional<StrainError> meshErrorOf(const ForceField& field, ConstRows x) {
  if (!isMembrane(field) && !kindOfLaw(field)) return {};
  const std::vector<Vec3>& rest = field.state().rest_position;
  const std::vector<Vec3> now = positionsOf(field.state(), x);
  if (now == rest) return {};
  constexpr double round_off = 1e-10;  // strains of rounded positions
  std::optional<StrainError> found;
  visitCells(field, [&](const auto& cells) {
    const StrainError error = strainError(cells, rest, now, modulusOf(field, cells.size()), bulkOf(field), volumeChangeOf(field));
    if (std::isfinite(error.error) && error.largest > round_off * round_off) found = error;
  });
  return found;
}

std::vector<std::string> meshErrors(const Simulation& simulation) {
  constexpr double limit = 0.03, most = 0.999;
  simulation.complete();
  const UnitSystem units = unitsOf(simulation.scene());
  std::vector<std::string> sentences;
  for (const auto& system : simulation.systems()) {
    double error = 0, all = 0, greatest = 0;
    const ForceField* worst = nullptr;
    for (const ForceField* field : system->forceFields()) {
      const auto own = meshErrorOf(*field, system->x);
      const double energy = own ? std::abs(field->energy(system->x)) : 0;
      if (!own || !std::isfinite(energy)) continue;
      const double share = std::min(own->share(), most), withheld = share / (1 - share) * energy;  // of what the body's own would be
      all += energy + withheld, error += withheld;
      if (withheld > greatest) greatest = withheld, worst = field;
    }
    if (!worst || error <= limit * all) continue;
    bool are_stiff = false, is_quadratic = false;
    visitCells(*worst, [&](const auto& cells) {
      const std::size_t nodes = cells.front().size();
      are_stiff = nodes >= 4 && nodes <= 6, is_quadratic = nodes == 10;
    });
    sentences.push_back(fmt::format(
        "{} at t = {:.6g}{}: by the jumps of the strain between cells the mesh is too coarse for this deformation: some "
        "{:.0f} % {}. Finer cells{} are closer",
        worst->path(), simulation.time(), units.behind("s"), 100 * error / all,
        is_quadratic && hasMeanDilatation(*worst) ? "off" : "too stiff",  // with four points and one volume they may be too soft
        are_stiff ? ", quadratic tetrahedra or hexahedra" : ""));
  }
  return sentences;
}

}  // namespace stroma
