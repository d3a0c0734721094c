// SPDX-License-Identifier: LGPL-2.1-or-later
// What the nodes of a state have besides their places: arrays of VTK that follow the state.
#pragma once
#include <vtkDoubleArray.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>

#include <string>
#include <vector>

#include "framework/mechanics/state.h"

namespace stroma {

class PointFields {
 public:
  /// Of rigid frames the array "orientation", quaternions x y z w; else nothing. Forgets all fields.
  void start(State& state, vtkPointData& data);
  /// `word`: `what` or `label=what`, as the user writes it; or an attribute of another component with a value for each node. Throws
  /// ComponentError for a field that the nodes do not have.
  void add(const std::string& word, const Component& exporter, vtkPointData& data);
  /// The present values, or those at the start of a state that nothing moves.
  void fill();

 private:
  enum class What { position, rest_position, displacement, velocity, force, angular_velocity, torque };
  struct Output {
    What what;
    vtkSmartPointer<vtkDoubleArray> values;
  };
  /// Of another component: what it computes for each node. Before it has, zero.
  struct Attribute {
    const Component* owner;
    const Data* data;
    vtkSmartPointer<vtkDoubleArray> values;
  };
  void addAttribute(const Component& owner, const std::string& name, const std::string& label, vtkPointData& data);
  void fill(const Attribute& attribute) const;
  Vec3 valueOf(What what, Index row) const;
  vtkSmartPointer<vtkDoubleArray> newArray(const std::string& label, int components, vtkPointData& data) const;

  State* state_ = nullptr;
  vtkSmartPointer<vtkDoubleArray> turns_;
  std::vector<Output> outputs_;
  std::vector<Attribute> attributes_;
};

}  // namespace stroma
