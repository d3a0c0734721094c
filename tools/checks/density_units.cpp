// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/checks/density_units.h"

#include <fmt/format.h>

#include <cstdlib>
#include <numbers>
#include <optional>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/mass.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_lists.h"
#include "tools/units/units.h"

namespace stroma {
namespace {

constexpr const char* density_units[] = {"", "kg/m", "kg/m^2", "kg/m^3"};  // of lines, areas, volumes
constexpr const char* cell_words[] = {"", "lines", "areas", "volumes"};
constexpr const char* per_words[] = {"", "length", "area", "volume"};

const AttributeDescription* writtenIn(const NodeDescription& node, const SourceLocation& where, std::string_view name) {
  for (const ComponentDescription& each : node.components)
    if (each.where.line == where.line && each.where.column == where.column && each.where.file == where.file)
      if (const AttributeDescription* found = each.find(name)) return found;
  for (const NodeDescription& child : node.children)
    if (const AttributeDescription* found = writtenIn(child, where, name)) return found;
  return nullptr;
}

/// 1, 2 or 3 for a mass per length, area or volume; 0: no such unit is written.
int dimensionOf(const AttributeDescription& density) {
  const std::string text = plainUnitText(density.value);
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (!isLetter(text[i])) continue;
    const std::optional<Unit> unit = findUnit(std::string_view(text).substr(i, text.find_last_not_of(" \t\n") + 1 - i));
    if (!unit) continue;
    for (int d = 1; d <= 3; ++d)
      if (unit->dimension == readUnit(density_units[d]).dimension) return d;
  }
  return 0;
}

const Topology* meshOf(const Mass& mass) {
  const Data* data = mass.data().find("topology");
  if (data && data->link())
    if (const auto* linked = dynamic_cast<const Topology*>(data->link()->target())) return linked;
  return topologyOf(mass.state());
}

/// Scenes of programs have no lines that tell their components apart.
bool isValueOf(const AttributeDescription& written, const Data& density) {
  const auto* list = std::get_if<std::vector<double>*>(&density.pointer());
  const std::optional<std::string> plain = withoutUnits(written.value, density.unitText());
  return list && !(*list)->empty() && plain && std::strtod(plain->c_str(), nullptr) == (**list)[0];
}

/// One number of an attribute; 0: none or several.
double numberIn(const Component& component, const char* name) {
  const Data* data = component.data().find(name);
  if (!data) return 0;
  if (const auto* number = std::get_if<double*>(&data->pointer())) return **number;
  const auto* list = std::get_if<std::vector<double>*>(&data->pointer());
  return list && (*list)->size() == 1 ? (**list)[0] : 0;
}

/// What a density per volume is on these cells by the thickness or radius of a force field of the state, or empty.
std::string adviceFor(const Scene& scene, const Mass& mass, int dimension) {
  std::vector<ForceField*> fields;
  scene.root->collect(fields);
  const double density = numberIn(mass, "massDensity");
  for (const ForceField* field : fields) {
    if (&field->state() != &mass.state() || density == 0) continue;
    const char* const name = dimension == 2 ? "thickness" : "radius";
    const double size = numberIn(*field, name);
    if (!(size > 0)) continue;
    const double value = density * (dimension == 2 ? size : std::numbers::pi * size * size);
    return fmt::format("massDensity=\"{:.6g} {}\" for the {} of {:.6g} m of {}", value, density_units[dimension], name, size,
                       field->path());
  }
  return dimension == 2 ? "a sheet has its density times its thickness" : "a beam has its density times its cross-section";
}

}  // namespace

void refuseDensitiesOfOtherCells(const Scene& scene, Diagnostics& diagnostics) {
  std::vector<Mass*> masses;
  scene.root->collect(masses);
  for (const Mass* mass : masses) {
    const Data* density = mass->data().find("massDensity");
    if (!density || density->origin() == DataOrigin::by_default || density->origin() == DataOrigin::linked) continue;
    const AttributeDescription* written = writtenIn(scene.description.root, mass->where(), "massDensity");
    const Topology* mesh = written && isValueOf(*written, *density) ? meshOf(*mass) : nullptr;
    const int is = mesh ? highestDimension(mesh->mesh()) : 0, said = mesh ? dimensionOf(*written) : 0;
    if (is == 0 || said == 0 || is == said) continue;
    diagnostics.error(written->where, mass->path() + ".massDensity",
                      fmt::format("massDensity is written as a mass per {}, and the cells of {} are {}", per_words[said], mesh->path(),
                                  cell_words[is]),
                      fmt::format("a mass per {}, such as {}", per_words[is], density_units[is]),
                      said == 3 ? adviceFor(scene, *mass, is) : "");
  }
}

}  // namespace stroma
