// SPDX-License-Identifier: LGPL-2.1-or-later
// Gives each cell the value of its label: a material by region.
//
// `labels` has one whole number per cell, as MeshGmshLoader's and MeshVTKLoader's tetrahedraGroups. `table` lists pairs
// of a label and its value, "1 10000  2 1e7"; with width="3" a label and its three values, "1  1 0 0   2  0 1 0", as
// AnisotropyDirections takes them (6: fibre and sheet). The output `values` has one value per cell and is what
// attributes like youngModulus, poissonRatio or localStiffnessFactor take: youngModulus="@stiffness.values". A label
// without a value is an error that names it, unless `defaultValue` is given; an entry of the table that no cell has is
// a warning.
//
// Source: the attribute of a cell by its region is that of every finite element program; SOFA has none for tables.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <StaticSolver/>
//   <SparseLDLSolver/>
//   <MeshTopology name="mesh" position="0 0 0  1 0 0  0 1 0  0 0 1  1 1 1" tetrahedra="0 1 2 3  1 2 3 4"/>
//   <MechanicalObject/>
//   <DiagonalMass massDensity="1000"/>
//   <ValuesFromLabels name="stiffness" labels="1 2" table="1 1e6  2 1e7"/>
//   <TetrahedronFEMForceField method="small" youngModulus="@stiffness.values" poissonRatio="0.3"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "framework/scene/component.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class ValuesFromLabels : public Component {
 public:
  std::string roleText() const override { return "engine"; }
  void declare(DataTable& table) override {
    table.add("labels", labels_).help("a label for each cell, as @loader.tetrahedraGroups").required();
    table.add("table", table_).help("pairs of a label and its value, or with width a label and its values").required();
    table.add("width", width_).min(1).help("values per label");
    table.add("defaultValue", default_).help("value of the labels that the table does not have");
    table.add("values", values_).help("the value of each cell, or its values one after the other").output();
  }

  void init() override {
    if (labels_.empty())
      throw ComponentError("labels is empty: the mesh has no labels", "a label per cell, as @loader.tetrahedraGroups");
    const Table values_of = readTable();
    const bool has_default = data().find("defaultValue")->isSet();
    std::map<int, long> missing;
    std::map<int, bool> used;
    values_.clear();
    values_.reserve(labels_.size() * std::size_t(width_));
    for (const int label : labels_) {
      const auto found = values_of.find(label);
      if (found == values_of.end() && !has_default) ++missing[label];
      used[label] = true;
      if (found == values_of.end())
        values_.insert(values_.end(), std::size_t(width_), default_);
      else
        values_.insert(values_.end(), found->second.begin(), found->second.end());
    }
    if (!missing.empty()) failMissing(missing, values_of);
    for (const auto& [label, values] : values_of)
      if (!used.count(label)) warn(fmt::format("no cell has the label {} of the table", label));
  }

 private:
  using Table = std::map<int, std::vector<double>>;

  Table readTable() const {
    const std::size_t width = std::size_t(width_), step = width + 1;
    if (table_.size() % step != 0)
      throw ComponentError(fmt::format("table has {} numbers", table_.size()),
                           width == 1 ? "pairs of a label and its value"
                                      : fmt::format("a label and its {} values, again and again", width));
    Table values_of;
    for (std::size_t i = 0; i < table_.size(); i += step) {
      if (table_[i] != std::floor(table_[i]) || std::abs(table_[i]) > 1e9)
        throw ComponentError(fmt::format("{} in table is not a label", table_[i]),
                             width == 1 ? "whole numbers at the first, third, ... place: label value label value"
                                        : fmt::format("a whole number before each {} values", width));
      const auto first = table_.begin() + std::ptrdiff_t(i) + 1;
      if (!values_of.emplace(int(table_[i]), std::vector<double>(first, first + width_)).second)
        throw ComponentError(fmt::format("table has the label {} twice", table_[i]), "each label once");
    }
    return values_of;
  }

  [[noreturn]] void failMissing(const std::map<int, long>& missing, const Table& values_of) const {
    std::string text, known;
    for (const auto& [label, cells] : missing)
      text += fmt::format("{}{} ({} cell{})", text.empty() ? "" : ", ", label, cells, cells == 1 ? "" : "s");
    for (const auto& [label, values] : values_of) known += fmt::format("{}{}", known.empty() ? "" : ", ", label);
    throw ComponentError(fmt::format("table has no value for label{} {}", missing.size() == 1 ? "" : "s", text),
                         fmt::format("a pair for each label (it has {}), or defaultValue", known));
  }

  std::vector<int> labels_;
  std::vector<double> table_, values_;
  double default_ = 0;
  int width_ = 1;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(values_from_labels) {
  factory.add<stroma::ValuesFromLabels>("ValuesFromLabels", "a value for each cell by its label: materials by region");
}
