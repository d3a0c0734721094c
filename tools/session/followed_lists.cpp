// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/followed_lists.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <string_view>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/mapping.h"
#include "framework/mechanics/state_topology.h"
#include "framework/simulation/observer.h"

namespace stroma {
namespace {

/// Attributes that have a value for each node where no list says of which.
constexpr std::string_view of_all_nodes[] = {"vertexMass", "property", "stiffness", "angularStiffness"};
/// Attributes, of text or of numbers, that name nodes among other things.
constexpr std::string_view mixed[] = {"spring", "springs", "oscillators", "cluster"};
/// Lists of one length: what goes from one that numbers nodes goes from all.
struct Together {
  std::string_view type;
  std::vector<std::string_view> names;
};
const Together together[] = {
    {"ConstantForceField", {"indices", "forces"}},
    {"AttachProjectiveConstraint", {"indices1", "indices2"}},
    {"SpringForceField", {"springsIndices1", "springsIndices2", "lengths", "stiffness", "damping"}},
    {"FixedLagrangianConstraint", {"indices"}},
    {"BilateralLagrangianConstraint", {"first_point", "second_point", "rest_vector"}},
    {"DistanceLagrangianConstraint", {"first_point", "second_point", "distances"}},
    {"RestShapeSpringsForceField", {"points", "external_points", "stiffness", "angularStiffness", "targets"}}};

/// How many entries a list has; 0: it is no list.
std::size_t countOf(const Data& data) {
  return std::visit(
      [](const auto& pointer) -> std::size_t {
        if constexpr (requires {
                        pointer->begin();
                        pointer->size();
                      }) {
          using Value = std::decay_t<decltype(*pointer)>;
          return std::is_same_v<Value, std::string> ? 0 : pointer->size();
        }
        return 0;
      },
      data.pointer());
}

template <class Value>
void append(std::string& text, const Value& value) {
  if constexpr (std::is_same_v<Value, Vec3>)
    fmt::format_to(std::back_inserter(text), "{} {} {} ", value[0], value[1], value[2]);
  else if constexpr (std::is_arithmetic_v<Value>)
    fmt::format_to(std::back_inserter(text), "{} ", value);
}

/// The entries of a list at `places`, each of `width` values.
std::string entriesAt(const Data& data, const std::vector<std::size_t>& places, std::size_t width) {
  std::string text;
  std::visit(
      [&](const auto& pointer) {
        if constexpr (requires {
                        pointer->begin();
                        (*pointer)[0];
                      }) {
          using Value = typename std::decay_t<decltype(*pointer)>::value_type;
          for (const std::size_t place : places)
            for (std::size_t k = 0; k < width; ++k) append<Value>(text, (*pointer)[place * width + k]);
        }
      },
      data.pointer());
  return text;
}

/// Numbers of a force on a node.
std::size_t widthOf(const Component& component) {
  for (const Node* node = &component.node(); node; node = node->parent())
    for (const auto& near : node->components())
      if (const auto* state = dynamic_cast<const State*>(near.get()))
        return state->kindOf(0) == RowKind::value ? std::size_t(state->rows_per_node) : 3 * std::size_t(state->rows_per_node);
  return 3;
}

std::string fillerType(const Topology& topology) {
  if (dynamic_cast<const TopologicalMapping*>(&topology)) return topology.type();
  std::vector<TopologicalMapping*> mappings;
  topology.node().root().collect(mappings);
  for (const TopologicalMapping* mapping : mappings)
    if (mapping->output() == &topology) return mapping->type();
  return {};
}

/// The mesh whose cells a component numbers.
const Topology* meshOf(const Component& component) {
  const Data* named = component.data().find("topology");
  if (named && named->link() && named->link()->target()) return dynamic_cast<const Topology*>(named->link()->target());
  const Topology* last = nullptr;
  for (const Node* node = &component.node(); node && !last; node = node->parent())
    for (const auto& near : node->components())
      if (const auto* topology = dynamic_cast<const Topology*>(near.get()); topology && topology->answersLookup())
        last = topology;
  return last;
}

bool isText(const Data& data) {
  auto* const* text = std::get_if<std::string*>(&data.pointer());
  return text && !(*text)->empty();
}

/// An entry less would change what the others mean.
bool needsAll(const Component& component) {
  const std::string type = component.type();
  return dynamic_cast<const Observer*>(&component) || component.roleText() == "Lagrangian constraint" ||
         type.starts_with("LinearRelation") || type.starts_with("Polynomial") || type.starts_with("AngularSpring");
}

[[noreturn]] void refuse(const Component& component, const Data& data, const std::string& why) {
  throw ComponentError(fmt::format("{}.{} {}", component.path(), data.name(), why),
                       "an attribute that does not count what changes");
}

}  // namespace

bool mayNumberPoints(const Data& data) {
  return std::holds_alternative<std::vector<int>*>(data.pointer()) ||
         (isIn(data.name(), mixed) && (countOf(data) > 0 || isText(data)));
}

FollowedLists::Left FollowedLists::numbersLeft(const std::vector<int>& numbers, const std::vector<Index>& now) const {
  Left left;
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const Index number =
        numbers[k] >= 0 && std::size_t(numbers[k]) < now.size() ? now[std::size_t(numbers[k])] : Index(numbers[k]);
    if (number < 0 && numbers[k] >= 0) continue;
    left.places.push_back(k);
    fmt::format_to(std::back_inserter(left.text), "{} ", number);
  }
  left.is_shorter = left.places.size() != numbers.size();
  return left;
}

/// What the numbers of an attribute are numbers of; null: of nothing of a mesh. Refuses those of which it is not known.
const ListOrigins* FollowedLists::numbered(const Component& component, const Data& data) const {
  const ListKind kind = kindOf(data.name());
  if (kind == ListKind::nothing) return nullptr;
  const std::vector<int>& numbers = *std::get<std::vector<int>*>(data.pointer());
  if (kind == ListKind::unknown && std::all_of(numbers.begin(), numbers.end(), [](int each) { return each < 0; })) return nullptr;
  const bool is_of_mapping = kind == ListKind::nodes && dynamic_cast<const Mapping*>(&component);
  if (kind == ListKind::unknown || (is_of_mapping && !edit_.points().areTheSame()))
    refuse(component, data, "may number points or cells of a mesh that changes");
  if (kind == ListKind::nodes) return is_of_mapping ? nullptr : &edit_.points();
  const ListOrigins* cells = originsOf(edit_, kind);
  if (meshOf(component) != &topology_)
    refuse(component, data, "numbers cells of a mesh that is made of the one that changes");
  return cells;
}

/// Of what an attribute with `count` values has one for each; null: of nothing that changes. By what it is declared to be.
FollowedLists::Valued FollowedLists::valued(const Component& component, const Data& data, std::size_t count) const {
  Valued found;
  std::size_t width = data.cellWidth();
  if (data.isOfNodes() || isIn(data.name(), of_all_nodes)) {
    width = 0;
    if (count > 1 && count == edit_.points().before) found = {&edit_.points(), 1};
  }
  if ((data.name() == "forces" && component.type() == "ConstantForceField") || data.name() == "targets") {
    const bool is_flat = std::holds_alternative<std::vector<double>*>(data.pointer());
    const std::size_t each = is_flat ? widthOf(component) : 1;
    if (count > each && count == each * edit_.points().before) found = {&edit_.points(), each};
  }
  const Topology* mesh = width > 0 && count > width ? meshOf(component) : nullptr;
  if (mesh && isMade_(*mesh))
    forEachCellList(
        [&](const CellKind&, const auto& cells, const ListOrigins& origins) {
          if (cells.size() < 2 || count != width * cells.size()) return;
          if (mesh == &topology_) found = {&origins, width};
          if (mesh == &topology_ || edit_.cells().hexahedra.areTheSame()) return;
          // a hexahedron is cut into as many tetrahedra, one after the other
          const std::size_t before = edit_.cells().hexahedra.before;
          if (fillerType(*mesh) != "Hexa2TetraTopologicalMapping" || before == 0 || cells.size() % before != 0)
            refuse(component, data, "has a value for each cell of a mesh that is made of the one that changes");
          found = {&edit_.cells().hexahedra, width * (cells.size() / before)};
        },
        mesh->mesh(), edit_.cells());
  if (found.origins && data.name() == "AnisotropyDirections" && (count <= 3 || count == edit_.points().before))
    refuse(component, data, "may be of all cells, of each cell or of each node");
  for (std::size_t each = 1; data.name() == "AnisotropyDirections" && !found.origins && each <= 3; ++each)
    if (count > 3 && count == each * edit_.points().before) found = {&edit_.points(), each};
  if (found.origins && found.origins->areTheSame()) return {};
  return found;
}

std::optional<std::string> FollowedLists::cellsLeft(const Data& data) const {
  const std::vector<Index> now = edit_.points().now();
  std::optional<std::string> text;
  std::visit(
      [&](const auto& pointer) {
        if constexpr (requires { std::tuple_size<typename std::decay_t<decltype(*pointer)>::value_type>::value; }) {
          using Cell = typename std::decay_t<decltype(*pointer)>::value_type;
          if constexpr (std::is_integral_v<typename Cell::value_type>) {
            text = "";
            for (const Cell& cell : *pointer) {
              if (std::any_of(cell.begin(), cell.end(), [&](auto node) { return now.at(std::size_t(node)) < 0; }))
                continue;
              for (const auto node : cell) append(*text, now[std::size_t(node)]);
            }
          }
        }
      },
      data.pointer());
  return text;
}

std::string FollowedLists::valuesOf(const State& state, const char* attribute) const {
  const Data& data = *state.data().find(attribute);
  std::string text;
  if (auto* const* places = std::get_if<std::vector<Vec3>*>(&data.pointer())) {
    for (const auto& shares : edit_.points().shares) {
      Vec3 sum = Vec3::Zero();
      for (const auto& [point, share] : shares) sum += share * (**places)[std::size_t(point)];
      append(text, sum);
    }
    return text;
  }
  const auto& flat = *std::get<std::vector<double>*>(data.pointer());
  const std::size_t width = flat.size() / std::size_t(state.nodes());
  for (const Index point : edit_.points().of) {
    if (point < 0)
      throw ComponentError(state.path() + " has frames or numbers: none can come between others", "points");
    for (std::size_t k = 0; k < width; ++k) append(text, flat[std::size_t(point) * width + k]);
  }
  return text;
}

std::set<std::string> FollowedLists::followTogether(const Component& component, const IsOfMesh& isOfMesh,
                                                    const Put& put, EntriesLeft& left) const {
  const auto group = std::find_if(std::begin(together), std::end(together),
                                  [&](const Together& each) { return each.type == component.type(); });
  if (group == std::end(together) || edit_.points().areTheSame()) return {};
  std::vector<const Data*> numbers, values;
  for (const std::string_view name : group->names) {
    const Data* data = component.data().find(name);
    if (!data || !data->isSet() || countOf(*data) == 0) continue;
    (std::holds_alternative<std::vector<int>*>(data->pointer()) ? numbers : values).push_back(data);
  }
  if (std::none_of(numbers.begin(), numbers.end(), [&](const Data* data) { return isOfMesh(*data); })) return {};
  const std::size_t count = countOf(*numbers[0]);
  const std::vector<Index> now = edit_.points().now();
  std::vector<bool> stays(count, true);
  for (const Data* data : numbers) {
    if (countOf(*data) != count) refuse(component, *data, "has not as many entries as " + numbers[0]->name());
    for (const std::size_t place : numbersLost(*data, isOfMesh(*data), now)) stays[place] = false;
  }
  std::vector<std::size_t> places;
  for (std::size_t k = 0; k < count; ++k)
    if (stays[k]) places.push_back(k);
  left = {count, {places.begin(), places.end()}};
  std::set<std::string> done;
  for (const Data* data : numbers) {
    const std::vector<int>& list = *std::get<std::vector<int>*>(data->pointer());
    std::string text;
    for (const std::size_t k : places)
      append(text, isOfMesh(*data) && list[k] >= 0 ? now.at(std::size_t(list[k])) : Index(list[k]));
    put(*data, text), done.insert(data->name());
  }
  for (const Data* data : values) {
    const bool is_flat = (data->name() == "forces" || data->name() == "targets") &&
                         std::holds_alternative<std::vector<double>*>(data->pointer());
    const std::size_t width = is_flat ? widthOf(component) : 1;
    if (countOf(*data) == count * width && countOf(*data) > width) put(*data, entriesAt(*data, places, width));
    done.insert(data->name());
  }
  nameExternal(component, isOfMesh, places, put);
  return done;
}

/// Springs to another body that take its nodes by the numbers of the points: those stay.
void FollowedLists::nameExternal(const Component& component, const IsOfMesh& isOfMesh,
                                 const std::vector<std::size_t>& places, const Put& put) const {
  const Data *points = component.data().find("points"), *others = component.data().find("external_points"),
             *shape = component.data().find("external_rest_shape");
  if (!points || !others || !shape || !shape->link() || !shape->link()->target() || others->isSet() || isOfMesh(*others))
    return;
  put(*others, entriesAt(*points, places, 1));
}

std::vector<std::size_t> FollowedLists::numbersLost(const Data& data, bool is_of_mesh, const std::vector<Index>& now) {
  std::vector<std::size_t> lost;
  const std::vector<int>& list = *std::get<std::vector<int>*>(data.pointer());
  for (std::size_t k = 0; is_of_mesh && k < list.size(); ++k)
    if (list[k] >= 0 && now.at(std::size_t(list[k])) < 0) lost.push_back(k);
  return lost;
}

/// A node that is named alone, also by the usual value.
void FollowedLists::followOne(const Component& component, const Data& data, const Put& put) const {
  int* const* number = std::get_if<int*>(&data.pointer());
  if (!number || **number < 0 || edit_.points().areTheSame()) return;
  const std::vector<Index> now = edit_.points().now();
  if (std::size_t(**number) >= now.size()) return;
  if (now[std::size_t(**number)] < 0) refuse(component, data, "names a point that goes");
  put(data, std::to_string(now[std::size_t(**number)]));
}

EntriesLeft FollowedLists::forEachChanged(const Component& component, const IsOfMesh& isOfMesh, const Put& put) const {
  EntriesLeft left_of_lists;
  const std::set<std::string> done = followTogether(component, isOfMesh, put, left_of_lists);
  for (const Data& data : component.data().all()) {
    if (namesOneNode(component.type(), data.name()) && isOfMesh(data)) followOne(component, data, put);
    if (!data.isSet() || data.isOutput() || data.link() || done.count(data.name()) || !isOfMesh(data)) continue;
    const std::size_t count = countOf(data);
    if (isIn(data.name(), mixed) && (count > 0 || isText(data)) && !edit_.points().areTheSame())
      refuse(component, data, "numbers points of a mesh that changes");
    if (count == 0) continue;
    if (auto* const* numbers = std::get_if<std::vector<int>*>(&data.pointer())) {
      const ListOrigins* origins = numbered(component, data);
      if (!origins) continue;
      const Left left = numbersLeft(**numbers, origins->now());
      if (origins->areTheSame()) continue;
      if (left.is_shorter && needsAll(component)) refuse(component, data, "names a point that goes");
      put(data, left.text);
      continue;
    }
    if (const std::optional<std::string> cells = cellsLeft(data)) {
      if (!edit_.points().areTheSame()) put(data, *cells);
      continue;
    }
    const Valued of = valued(component, data, count);
    if (!of.origins) continue;
    std::vector<std::size_t> places;
    for (const Index number : of.origins->of) {
      if (number < 0) refuse(component, data, "has no value for what has come");
      places.push_back(std::size_t(number));
    }
    put(data, entriesAt(data, places, of.width));
  }
  return left_of_lists;
}

}  // namespace stroma
