// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/vtk_io/point_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <type_traits>

#include "components/vtk_io/field_word.h"
#include "framework/mechanics/frames.h"
#include "framework/scene/node.h"

namespace stroma {

namespace {

constexpr std::size_t words_of_points = 5;
const std::vector<std::string> field_words{"position", "restPosition", "displacement",   "velocity",
                                     "force",    "angularVelocity", "torque"};

}  // namespace

void PointFields::start(State& state, vtkPointData& data) {
  state_ = &state;
  outputs_.clear(), attributes_.clear();
  turns_ = state.hasFrames() ? newArray("orientation", 4, data) : nullptr;
}

vtkSmartPointer<vtkDoubleArray> PointFields::newArray(const std::string& label, int components, vtkPointData& data) const {
  auto array = vtkSmartPointer<vtkDoubleArray>::New();
  array->SetName(label.c_str());
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(state_->nodes());
  data.AddArray(array);
  return array;
}

void PointFields::add(const std::string& word, const Component& exporter, vtkPointData& data) {
  FieldWord parts(word);
  if (const Component* owner = parts.owner.empty() ? nullptr : &componentAt(exporter.node(), parts.owner); owner && owner != state_)
    return addAttribute(*owner, parts.field, parts.label.empty() ? parts.field : parts.label, data);
  if (parts.field == "rest_position") parts.field = "restPosition";  // SOFA's name of the attribute
  const std::vector<std::string> known(field_words.begin(),
                                       state_->hasFrames() ? field_words.end() : field_words.begin() + words_of_points);
  const auto found = std::find(known.begin(), known.end(), parts.field);
  if (found == known.end())
    throw ComponentError(fmt::format("pointsDataFields: '{}' is not a field of nodes", parts.field),
                         state_->hasFrames()
                             ? "position, restPosition, displacement, velocity, force, angularVelocity or torque"
                             : "position, restPosition, displacement, velocity or force",
                         nearest(parts.field, known));
  const What what = What(found - known.begin());
  if (what == What::force || what == What::torque) state_->requestForce();
  outputs_.push_back({what, newArray(parts.label.empty() ? parts.field : parts.label, 3, data)});
}

void PointFields::addAttribute(const Component& owner, const std::string& name, const std::string& label, vtkPointData& data) {
  if (dynamic_cast<const State*>(&owner))  // its attributes are the start, not where its nodes are
    throw ComponentError(fmt::format("pointsDataFields: {} is not of the state that is exported", owner.path()),
                         fmt::format("fields of {}, or an exporter in the node of {}", state_->path(), owner.path()));
  const Data* found = owner.data().find(name);
  if (!found)
    throw ComponentError(fmt::format("pointsDataFields: {} has no attribute '{}'", owner.path(), name),
                         "an attribute with a value for each node", nearest(name, owner.data().names()));
  const DataPointer& pointer = found->pointer();
  const bool of_points = std::holds_alternative<std::vector<Vec3>*>(pointer);
  if (!of_points && !std::holds_alternative<std::vector<double>*>(pointer) && !std::holds_alternative<std::vector<int>*>(pointer))
    throw ComponentError(fmt::format("pointsDataFields: {} of {} is a {}", name, owner.path(), found->typeText()),
                         "a list of numbers or of vectors, one for each node");
  attributes_.push_back({&owner, found, newArray(label, of_points ? 3 : 1, data)});
}

void PointFields::fill(const Attribute& attribute) const {
  const std::size_t nodes = std::size_t(state_->nodes());
  double* out = attribute.values->GetPointer(0);
  const auto copy = [&](const auto* list) {
    if (list->empty()) return std::fill_n(out, nodes * std::size_t(attribute.values->GetNumberOfComponents()), 0.), void();
    if (list->size() != nodes)
      throw ComponentError(fmt::format("pointsDataFields: {} of {} has {} values, and {} has {} nodes", attribute.data->name(),
                                       attribute.owner->path(), list->size(), state_->path(), nodes),
                           "one for each node");
    for (const auto& value : *list)
      if constexpr (std::is_same_v<std::decay_t<decltype(value)>, Vec3>)
        out = std::copy_n(value.data(), 3, out);
      else
        *out++ = double(value);
  };
  const DataPointer& pointer = attribute.data->pointer();
  if (const auto* points = std::get_if<std::vector<Vec3>*>(&pointer)) copy(*points);
  if (const auto* numbers = std::get_if<std::vector<double>*>(&pointer)) copy(*numbers);
  if (const auto* whole = std::get_if<std::vector<int>*>(&pointer)) copy(*whole);
  attribute.values->Modified();
}

/// `row`: the first of a node; a frame's orientation follows its centre.
Vec3 PointFields::valueOf(What what, Index row) const {
  const bool bound = state_->isBound();
  const auto place = [&] { return bound ? Vec3(state_->x()[row]) : state_->position[std::size_t(row)]; };
  const auto velocity = [&](Index at) { return bound ? Vec3(state_->v()[at]) : state_->velocity[std::size_t(at)]; };
  const auto force = [&](Index at) { return bound ? Vec3(state_->f()[at]) : Vec3(Vec3::Zero()); };
  switch (what) {
    case What::position: return place();
    case What::rest_position: return state_->rest_position[std::size_t(row)];
    case What::displacement: return place() - state_->rest_position[std::size_t(row)];
    case What::velocity: return velocity(row);
    case What::force: return force(row);
    case What::angular_velocity: return velocity(row + 1);
    case What::torque: return force(row + 1);
  }
  return Vec3::Zero();
}

void PointFields::fill() {
  for (Index node = 0; node < state_->nodes(); ++node) {
    const Index row = node * state_->rows_per_node;
    for (Output& output : outputs_) {
      const Vec3 value = valueOf(output.what, row);
      std::copy_n(value.data(), 3, output.values->GetPointer(3 * vtkIdType(node)));
    }
    if (!turns_) continue;
    const Quaternion q =
        state_->isBound() ? orientationIn(state_->x(), row + 1) : turnedBy(state_->position[std::size_t(row + 1)]);
    std::copy_n(q.coeffs().data(), 4, turns_->GetPointer(4 * vtkIdType(node)));
  }
  for (const Attribute& attribute : attributes_) fill(attribute);
  // VTK keeps the ranges of arrays that nobody calls changed, and writes them
  for (Output& output : outputs_) output.values->Modified();
  if (turns_) turns_->Modified();
}

}  // namespace stroma
