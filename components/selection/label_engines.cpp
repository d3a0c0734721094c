// SPDX-License-Identifier: LGPL-2.1-or-later
// Nodes and cells by the labels that they have, before the first step. Labels of several nodes are lists in brackets, one for each
// node or cell: "[1] [1,2] []".
//
// MergeROIs: roiIndices, the nbROIs lists indices1, indices2, ... as such lists (at most eight).
// SelectLabelROI: indices, where a list of `labels` has one of selectLabels.
// SelectConnectedLabelsROI: indices, where two of the nbLabels lists labels1, labels2, ... have a pair of connectLabels, in any order.
// GroupFilterYoungModulus: youngModulus, of each cell by its group (`groups`, as @loader.tetrahedraGroups, or elementsGroup):
//   mapGroupModulus="3 5e3; 4 1e4;" has pairs of a group and its modulus, groupModulus a modulus for each group in the order in which
//   they first appear. Groups without a modulus have defaultYoungModulus.
// MapIndices: out, each index of `in` by its place in `indices`, or with transpose by what stands there; others stay.
//
// Source: names and attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerExplicitSolver/>
//   <MergeROIs name="both" nbROIs="2" indices1="0 1" indices2="1 2"/>
//   <SelectLabelROI name="ones" labels="@both.roiIndices" selectLabels="2"/>
//   <SelectConnectedLabelsROI name="border" nbLabels="2" labels1="[1] [2] [1]" labels2="[1] [1] [2]" connectLabels="1 2"/>
//   <GroupFilterYoungModulus name="stiffness" groups="3 3 4" mapGroupModulus="3 5e3; 4 1e4;"/>
//   <MapIndices name="mapped" in="4 2" indices="2 3 4"/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="@border.indices"/>
//   <RestShapeSpringsForceField points="@mapped.out" stiffness="10"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <set>

#include "components/selection/engine.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

constexpr std::size_t most_lists = 8;
using Lists = std::vector<std::vector<int>>;

/// "[1,2] [3]" as lists.
Lists listsOf(const std::string& text, const std::string& name) {
  const auto fail = [&name](std::string_view what) {
    throw ComponentError(name + " holds " + std::string(what), "lists of whole numbers in brackets, as [1] [1,2] []");
  };
  Lists lists;
  bool open = false;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (c == ' ' || c == ',' || c == '\n' || c == '\t' || c == '\r') {
      ++at;
    } else if (c == '[' && !open) {
      lists.emplace_back(), open = true, ++at;
    } else if (c == ']' && open) {
      open = false, ++at;
    } else {
      int value = 0;
      const auto [end, error] = std::from_chars(text.data() + at, text.data() + text.size(), value);
      if (error != std::errc() || !open) fail("'" + text.substr(at, 20) + "'");
      lists.back().push_back(value);
      at = std::size_t(end - text.data());
    }
  }
  if (open) fail("a list that does not end");
  return lists;
}

class MergeROIs final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("nbROIs", count_).help("how many lists").min(1).max(int(most_lists));
    for (std::size_t i = 0; i < most_lists; ++i)
      table.add(fmt::format("indices{}", i + 1), in_[i]).help(fmt::format("list {}", i + 1));
    table.add("roiIndices", merged_).help("the lists, each in brackets").output();
  }
  void init() override {
    merged_.clear();
    for (std::size_t i = 0; i < std::size_t(count_); ++i)
      merged_ += fmt::format("{}[{}]", i == 0 ? "" : " ", fmt::join(in_[i], ","));
  }

 private:
  int count_ = 1;
  std::array<std::vector<int>, most_lists> in_;
  std::string merged_;
};

class SelectLabelROI final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("labels", labels_).help("labels of each node or cell, in brackets").required();
    table.add("selectLabels", wanted_).help("the labels to select");
    table.add("indices", indices_).help("nodes or cells with one of them").output();
  }
  void init() override {
    indices_.clear();
    const std::set<int> wanted(wanted_.begin(), wanted_.end());
    const Lists lists = listsOf(labels_, "labels");
    for (std::size_t i = 0; i < lists.size(); ++i)
      if (std::any_of(lists[i].begin(), lists[i].end(), [&wanted](int label) { return wanted.count(label) > 0; }))
        indices_.push_back(int(i));
    if (indices_.empty()) warn("no list has one of selectLabels");
  }

 private:
  std::string labels_;
  std::vector<int> wanted_, indices_;
};

class SelectConnectedLabelsROI final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("nbLabels", count_).help("how many lists of labels").min(2).max(int(most_lists));
    for (std::size_t i = 0; i < most_lists; ++i)
      table.add(fmt::format("labels{}", i + 1), labels_[i]).help("labels of each node or cell, in brackets");
    table.add("connectLabels", pairs_).help("pairs of labels that meet");
    table.add("indices", indices_).help("nodes or cells where they do").output();
  }
  void init() override {
    indices_.clear();
    if (pairs_.size() % 2 != 0)
      throw ComponentError(fmt::format("connectLabels has {} numbers: one has no other", pairs_.size()), "pairs of labels");
    std::set<std::pair<int, int>> pairs;
    for (std::size_t i = 0; i + 1 < pairs_.size(); i += 2)
      pairs.emplace(pairs_[i], pairs_[i + 1]), pairs.emplace(pairs_[i + 1], pairs_[i]);
    std::vector<Lists> all;
    for (std::size_t l = 0; l < std::size_t(count_); ++l) all.push_back(listsOf(labels_[l], fmt::format("labels{}", l + 1)));
    for (std::size_t l = 1; l < all.size(); ++l)
      if (all[l].size() != all[0].size())
        throw ComponentError(fmt::format("labels{} has {} lists, and labels1 has {}", l + 1, all[l].size(), all[0].size()),
                             "a list for each node or cell in both");
    for (std::size_t i = 0; i < all[0].size(); ++i)
      if (meets(all, i, pairs)) indices_.push_back(int(i));
    if (indices_.empty()) warn("no pair of connectLabels meets anywhere");
  }

 private:
  static bool meets(const std::vector<Lists>& all, std::size_t i, const std::set<std::pair<int, int>>& pairs) {
    for (std::size_t one = 0; one < all.size(); ++one)
      for (std::size_t other = 0; other < one; ++other)
        for (const int a : all[one][i])
          for (const int b : all[other][i])
            if (pairs.count({a, b})) return true;
    return false;
  }
  int count_ = 2;
  std::array<std::string, most_lists> labels_;
  std::vector<int> pairs_, indices_;
};

class GroupFilterYoungModulus final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("groups", groups_).help("the group of each cell, as @loader.tetrahedraGroups");
    table.add("elementsGroup", others_).help("the same, where groups is not given");
    table.add("mapGroupModulus", map_).help("pairs of a group and its modulus, each with a semicolon behind");
    table.add("groupModulus", moduli_).help("a modulus for each group in the order in which they first appear").unit("Pa");
    table.add("defaultYoungModulus", otherwise_).help("of groups without one").unit("Pa");
    table.add("youngModulus", values_).help("of each cell").unit("Pa").output();
    table.addVisualOnly("primitives");
  }
  void init() override {
    const std::vector<int>& groups = groups_.empty() ? others_ : groups_;
    constexpr double none = -1;
    std::vector<int> order;
    std::map<int, double> modulus;
    for (const int group : groups)
      if (modulus.emplace(group, none).second) order.push_back(group);
    if (!moduli_.empty() && !groups_.empty()) {
      for (std::size_t i = 0; i < std::min(order.size(), moduli_.size()); ++i) modulus[order[i]] = moduli_[i];
    } else {
      readMap(modulus);
    }
    if (moduli_.size() > (groups_.empty() ? 0 : order.size()))
      warn(groups_.empty() ? "groupModulus counts with groups alone"
                           : fmt::format("groupModulus has {} values for {} groups", moduli_.size(), order.size()));
    const auto without = std::ranges::find(order, none, [&modulus](int group) { return modulus[group]; });
    if (without != order.end() && !data().find("defaultYoungModulus")->isSet())
      warn(fmt::format("groups without a modulus, as {}, have {:g} Pa, as defaultYoungModulus is not given", *without, otherwise_));
    values_.clear();
    for (const int group : groups) values_.push_back(modulus[group] == none ? otherwise_ : modulus[group]);
  }

 private:
  void readMap(std::map<int, double>& modulus) const {
    for (std::size_t at = 0, end = map_.find(';'); end != std::string::npos; at = end + 1, end = map_.find(';', at)) {
      const std::string pair = map_.substr(at, end - at);
      char* after = nullptr;
      const long group = std::strtol(pair.c_str(), &after, 10);
      char* behind = nullptr;
      const double value = std::strtod(after, &behind);
      if (after == pair.c_str() || behind == after || !(value > 0))
        throw ComponentError("mapGroupModulus holds '" + pair + "'", "a group, a modulus > 0 and a semicolon, again and again");
      const auto found = modulus.find(int(group));
      if (found == modulus.end())
        warn(fmt::format("no cell is of the group {} of mapGroupModulus", group));
      else
        found->second = value;
    }
    const std::size_t last = map_.rfind(';');
    if (map_.find_first_not_of(" \t\n\r", last == std::string::npos ? 0 : last + 1) != std::string::npos)
      throw ComponentError("mapGroupModulus does not end with a semicolon: its last pair would not count", "a semicolon behind each pair");
  }
  std::vector<int> groups_, others_;
  std::string map_;
  std::vector<double> moduli_, values_;
  double otherwise_ = 10000;
};

class MapIndices final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("in", in_).help("indices to map");
    table.add("indices", indices_).help("the old index of each new one, or with transpose the new index of each old one");
    table.add("transpose", transpose_).help("the map the other way round");
    table.add("out", out_).alias("outStr").help("the mapped indices").output();
  }
  void init() override {
    std::map<int, int> next;
    for (std::size_t i = 0; i < indices_.size(); ++i)
      next[transpose_ ? int(i) : indices_[i]] = transpose_ ? indices_[i] : int(i);
    out_ = in_;
    for (int& index : out_)
      if (const auto found = next.find(index); found != next.end()) index = found->second;
  }

 private:
  std::vector<int> in_, indices_, out_;
  bool transpose_ = false;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(label_engines) {
  using namespace stroma;
  factory.add<MergeROIs>("MergeROIs", "lists of indices, one after another in brackets");
  factory.add<SelectLabelROI>("SelectLabelROI", "nodes or cells with one of some labels");
  factory.add<SelectConnectedLabelsROI>("SelectConnectedLabelsROI", "nodes or cells where two lists have labels that meet");
  factory.add<GroupFilterYoungModulus>("GroupFilterYoungModulus", "a modulus for each cell by its group");
  factory.add<MapIndices>("MapIndices", "indices renumbered by a list");
}
