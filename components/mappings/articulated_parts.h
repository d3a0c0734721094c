// SPDX-License-Identifier: LGPL-2.1-or-later
// What a scene says of an articulated system: its joints, and the hinges and slides of each.
#pragma once
#include <fmt/format.h>

#include <string>

#include "framework/scene/component.h"
#include "framework/scene/types.h"

namespace stroma {

class ArticulatedPart : public Component {
 public:
  void init() override {}
  std::string roleText() const override { return "part of an articulated system"; }
};

class ArticulatedHierarchyContainer final : public ArticulatedPart {
 public:
  void declare(DataTable& table) override {
    table.add("filename", file_name_).help("not available: the centres are components");
  }
  void init() override {
    if (!file_name_.empty())
      throw ComponentError("hierarchies are not read from files", "ArticulationCenter components");
  }

 private:
  std::string file_name_;
};

class ArticulationCenter final : public ArticulatedPart {
 public:
  void declare(DataTable& table) override {
    table.add("parentIndex", parent).help("frame nearer to the root").required().min(0);
    table.add("childIndex", child).help("frame beyond it").required().min(0);
    table.add("posOnParent", on_parent).unit("m").help("the joint in the axes of the parent");
    table.add("posOnChild", on_child).unit("m").help("the joint in the axes of the child");
    table.add("articulationProcess", process_).help("0: the articulations follow one after the other");
    table.addVisualOnly("globalPosition");
  }
  void init() override {
    if (process_ != 0) throw ComponentError(fmt::format("articulationProcess is {}", process_), "0");
  }
  int parent = 0, child = 0;
  Vec3 on_parent = Vec3::Zero(), on_child = Vec3::Zero();

 private:
  int process_ = 0;
};

class Articulation final : public ArticulatedPart {
 public:
  void declare(DataTable& table) override {
    table.add("translation", translation).help("a slide");
    table.add("rotation", rotation).help("a hinge");
    table.add("rotationAxis", axis).alias("axis").help("of the hinge or the slide, in the axes of the parent").unit("-");
    table.add("articulationIndex", number).help("number of the state that is followed").min(0);
  }
  void init() override {
    if (translation == rotation)
      throw ComponentError(
          rotation ? "an articulation is a hinge and a slide" : "an articulation is neither hinge nor slide",
          "rotation=\"true\" or translation=\"true\"");
    if (!(axis.norm() > 0)) throw ComponentError("rotationAxis has no direction", "an axis that is not zero");
    axis.normalize();
  }
  bool translation = false, rotation = false;
  Vec3 axis = Vec3::UnitX();
  int number = 0;
};

}  // namespace stroma
