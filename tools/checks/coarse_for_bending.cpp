// SPDX-License-Identifier: LGPL-2.1-or-later
// The note on cells that are too coarse for bending (cells_across.h has the formulas).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "framework/mechanics/open_choices.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "tools/checks/cells_across.h"

namespace stroma {

/// What incompatible modes leave, in words: empty where that is not known.
static std::string leftByModes(double lean, const Slenderness& body, const BendingLaw& law, double limit) {
  const double steps = body.step * body.thickness / (2 * body.extent), error = lean + steps * steps;  // one curvature in each cell
  const double percent = 100 * error / (1 + error);
  if (!law.may_have_them || !(body.step > 0)) return {};
  if (!law.has_mean_dilatation && law.poisson_ratio > 0.4) return "; these bend better with incompatibleModes=\"true\"";
  return error < limit ? ", and so are these with incompatibleModes=\"true\""
                       : fmt::format("; these are some {:.2g} % too stiff with incompatibleModes=\"true\"", percent);
}

std::string tooCoarseForBending(const Slenderness& body, bool hexahedra, const BendingLaw& law) {
  constexpr double share_tetrahedra = 3, limit = 0.03;  // measured on cantilevers under their weight of 4 and 8 cubes over the height
  if (!body.isSlender() || !(body.cells > 0)) return {};
  const double nu = law.poisson_ratio, n = body.cells, shear = 1 / (2 * (1 + nu)), step2 = body.step * body.step;
  const double volume = law.has_mean_dilatation ? 0 : 1.1 * nu * nu / (1 - 2 * nu);
  const double lean = 3 * (body.lean * body.lean + shear * body.lean_in_plan * body.lean_in_plan);  // times a^2 / h^2
  const double cubes = hexahedra ? shear + volume + lean : share_tetrahedra;                        // times 1 / n^2
  const bool is_known = hexahedra && body.step > 0;
  const auto stiffness = [](double error) { return fmt::format("{:.0f} % too stiff", 100 * error / (1 + error)); };
  if (law.has_incompatible_modes) {
    if (!is_known || lean * step2 < limit) return {};
    return fmt::format(
        "hexahedra {:.3g} long lie over a thickness of {:.3g}, and their end faces lean to and fro by a tangent of {:.2g}: in bending the "
        "body is some {}, with incompatible modes too. Parallel end faces, or cells {:.2g} long, are within 3 %",
        body.step * body.thickness, body.thickness, std::hypot(body.lean, body.lean_in_plan), stiffness(lean * step2),
        body.thickness * std::sqrt(limit / lean));
  }
  const double error = is_known ? (shear + lean) * step2 + volume / (n * n) : cubes / (n * n);
  if (error < limit) return {};
  const bool are_long = is_known && body.step * n > 1.5;
  return fmt::format(
      "{:.2g} {} lie over a thickness of {:.3g} in a body of {:.3g}{}: coarse for bending, where it is some {}. {} over the "
      "thickness{} are within 3 %{}{}",
      n, hexahedra ? "hexahedra" : "tetrahedra", body.thickness, body.extent,
      are_long ? fmt::format(", and are {:.3g} long", body.step * body.thickness) : "", stiffness(error),
      std::ceil(std::sqrt(cubes / limit)), are_long ? ", as long as high," : "",
      hexahedra ? "" : "; so are fewer hexahedra, which bend better", hexahedra ? leftByModes(lean * step2, body, law, limit) : "");
}

bool hasMeanDilatation(const ForceField& field) {
  const Data* dilatation = field.data().find("dilatation");
  const auto* open = dynamic_cast<const OpenChoices*>(&field);
  return dilatation && (dilatation->print() == "mean" || (open && open->choice().find("mean") != std::string::npos));
}

bool hasIncompatibleModes(const ForceField& field) {
  const Data* modes = field.data().find("incompatibleModes");
  return modes && modes->print() == "true";
}

/// An axis along which every node of a state is held, or zero.
static Vec3 heldAxis(const System& system, const State& state) {
  const ConstraintSet& constraints = system.constraints();
  if (constraints.change() || state.rows_per_node != 1 || state.firstRow() >= system.independentRows()) return Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    Index held = 0;
    for (Index row = state.firstRow(); held < state.size(); ++row, ++held) {
      const Index at = constraints.projectorOf(row);
      if (at < 0 || !constraints.projectors()[std::size_t(at)].projector.col(axis).isZero(0)) break;
    }
    if (held == state.size()) return Vec3::Unit(axis);
  }
  return Vec3::Zero();
}

const CellKind* kindOfLaw(const ForceField& field) {
  constexpr const char* stress = "vonMises";
  const std::vector<std::string> known = field.cellFields();
  return std::find(known.begin(), known.end(), stress) == known.end() ? nullptr : field.cellFieldShape(stress).kind;
}

/// A clause where `dilatation` is left open and Poisson's ratio is near that from which it is another: what is left open in a fit or a
/// sweep is then no smooth function of it. A mean leaves the volume change of bending within a cell without energy.
static std::string jumpOfDilatation(const ForceField& field, const Slenderness& body, bool hexahedra) {
  constexpr double near = 0.05;
  const Data *dilatation = field.data().find("dilatation"), *ratio = field.data().find("poissonRatio");
  const bool elastic = field.data().find("method");  // hyperelastic tetrahedra have no mean, and may have no ratio
  if (!dilatation || !ratio || dilatation->print() != "auto" || !(elastic || (hexahedra && ratio->isSet()))) return {};
  const double from = hexahedra ? 0.4 : 0.45;
  std::istringstream values(ratio->print());
  double largest = 0;
  for (double value = 0; values >> value;) largest = std::max(largest, value);
  if (!(std::abs(largest - from) <= near)) return {};
  // measured on cantilevers four times as long as high, of 1, 2 and 4 cells over the height: 125, 20 and 6 %; of tetrahedra 125, 90 and
  // 40 % with six in each cube, with five 18, 21 and 8 %
  const double n2 = body.cells * body.cells;
  const double jump = hexahedra ? 0.8 / n2 * (1 + 0.5 / n2) : 9.6 / (n2 + 6.7);
  return fmt::format("; with dilatation=\"auto\" it bends by {} {:.0f} % more from Poisson's ratio {:g} on, where cells take a mean "
                     "volume change: write \"local\" or \"mean\" where the ratio is varied",
                     hexahedra ? "some" : "up to", 100 * jump, from);
}

static bool mayHaveIncompatibleModes(const ForceField& field) {
  const auto is = [&](const char* name, const char* word) {
    const Data* data = field.data().find(name);
    return data && data->print() == word;
  };
  return is("incompatibleModes", "false") && is("updateStiffnessMatrix", "false") && is("polarOf", "gradient") &&
         !is("method", "green") && !is("method", "green_lagrange");
}

static BendingLaw bendingLawOf(const ForceField& field) {
  BendingLaw law{.has_mean_dilatation = hasMeanDilatation(field),
                 .has_incompatible_modes = hasIncompatibleModes(field),
                 .may_have_them = mayHaveIncompatibleModes(field)};
  const Data* ratio = field.data().find("poissonRatio");
  const auto* list = ratio ? std::get_if<std::vector<double>*>(&ratio->pointer()) : nullptr;
  if (list && !(*list)->empty()) law.poisson_ratio = *std::max_element((*list)->begin(), (*list)->end());
  return law;
}

/// Cells of the kind of its law, in a mesh of its state.
static std::string coarsenessOf(const ForceField& field, const CellKind& kind, const Vec3& held) {
  const std::vector<Vec3>& rest = field.state().rest_position;
  for (const Topology* topology : topologiesOf(field.state())) {
    const Mesh& mesh = topology->mesh();
    if (mesh.overlap != 1 || std::size_t(mesh.nodes()) > rest.size()) continue;
    const bool hexahedra = kind.type == CellType::hexahedron && !mesh.hexahedra.empty();
    if (!hexahedra && (kind.type != CellType::tetrahedron || mesh.tetrahedra.empty())) continue;
    const Slenderness body = hexahedra ? slenderness(mesh.hexahedra, rest, held) : slenderness(mesh.tetrahedra, rest, held);
    const std::string coarse = tooCoarseForBending(body, hexahedra, bendingLawOf(field));
    return coarse.empty() ? coarse : coarse + jumpOfDilatation(field, body, hexahedra);
  }
  return {};
}

void noteCoarseCells(const Simulation& simulation, Diagnostics& diagnostics) {
  for (const auto& system : simulation.systems())
    for (const ForceField* field : system->forceFields()) {
      const CellKind* kind = kindOfLaw(*field);
      if (!kind) continue;
      if (const std::string coarse = coarsenessOf(*field, *kind, heldAxis(*system, field->state())); !coarse.empty())
        diagnostics.note(field->where(), field->path(), coarse);
    }
}

}  // namespace stroma
