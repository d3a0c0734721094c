// SPDX-License-Identifier: LGPL-2.1-or-later
// Lists of values made of others, before the first step. `template` says what a value is: double, int, Vec3, Rigid3, ...
//
// ValuesFromIndices: out, the values of `in` at `indices`, in their order.
// IndicesFromValues: indices, where each of `values` stands first in `global`; those that do not stand there are left out.
//   With recursiveSearch, every place where one stands. otherIndices are then the places where none of them does.
// IndexValueMapper: outputValues, inputValues with `value` at `indices`; the list grows as far as they reach, by defaultValue.
// Indices2ValuesMapper: outputValues, for each of inputValues that of `values` whose place in `indices` has it, else defaultValue.
// MergeVectors: output, the nbInputs lists input1, input2, ... one after another (at most eight).
// MergeSets: out, the union (op: or intersection, difference, symmetric_difference) of in1 and in2, ascending.
// MergePoints: points, position1 and then position2; indices1 and indices2 say where they are. With mappingX2 the points of
//   position2 take the places of position1 that it lists.
// DifferenceEngine: output, input minus substractor, value by value.
// MathOp: output, the lists input1, input2, ... joined number by number with op + - * or /, or the least (<) or largest (>) of them;
//   one of a single value counts for all. Of one list alone - is the opposite, and / the inverse of each number.
// ComplementaryROI: indices, the nodes of `position` that are in none of setIndices1, setIndices2, ... (nbSet of them).
//
// Source: names and attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerExplicitSolver/>
//   <MergePoints name="all" position1="0 0 0  1 0 0" position2="0 1 0"/>
//   <MathOp name="moved" template="Vec3" nbInputs="2" input1="@all.points" input2="0 0 1" op="+"/>
//   <DifferenceEngine name="back" template="Vec3" input="@moved.output" substractor="0 0 1  0 0 1  0 0 1"/>
//   <ValuesFromIndices name="ends" template="Vec3" in="@moved.output" indices="0 2"/>
//   <IndicesFromValues name="where" template="Vec3" values="0 1 1" global="@moved.output"/>
//   <IndexValueMapper name="soft" indices="@where.indices" value="10" defaultValue="50"/>
//   <Indices2ValuesMapper name="of_labels" inputValues="1 2 1" indices="1 2" values="10 20"/>
//   <MergeVectors name="list" nbInputs="2" input1="1 2" input2="3"/>
//   <MergeSets name="both" in1="0 1" in2="1 2"/>
//   <MechanicalObject position="@moved.output"/>
//   <ComplementaryROI name="others" position="@moved.output" nbSet="1" setIndices1="@where.indices"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="@others.indices"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>

#include "components/selection/engine.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

constexpr std::size_t most_inputs = 8;

class ValuesFromIndices final : public TypedEngine {
 public:
  void declare(DataTable& table) override {
    TypedEngine::declare(table);
    addList(table, "in", in_).alias("input").help("values to choose from");
    table.add("indices", indices_).help("which");
    addList(table, "out", out_).alias("output").alias("outStr").help("the chosen ones").output();
  }
  void init() override {
    checkWhole(in_, "in");
    out_.clear();
    withNumbers(
        [this](const auto& in, auto& out) {
          for (const int index : indices_) {
            if (index < 0 || std::size_t(index) >= count(in_))
              throw ComponentError(fmt::format("indices names {}, and there are {} values", index, count(in_)));
            copyValue(in, std::size_t(index), out);
          }
        },
        in_, out_);
  }

 private:
  ValueList in_, out_;
  std::vector<int> indices_;
};

class IndicesFromValues final : public TypedEngine {
 public:
  void declare(DataTable& table) override {
    TypedEngine::declare(table);
    addList(table, "values", values_).help("values to look for");
    addList(table, "global", global_).help("where to look");
    table.add("recursiveSearch", all_).help("every place where a value stands, not only the first");
    table.add("indices", indices_).help("where they stand").output();
    table.add("otherIndices", others_).help("with recursiveSearch: places where none of them stands").output();
  }
  void init() override {
    checkWhole(values_, "values"), checkWhole(global_, "global");
    indices_.clear(), others_.clear();
    std::vector<char> taken(count(global_));
    withNumbers([&](const auto& values, const auto& global) { find(values, global, taken); }, values_, global_);
    for (std::size_t g = 0; g < taken.size() && all_; ++g)
      if (!taken[g]) others_.push_back(int(g));
    if (indices_.empty()) warn("none of the values stands in global");
  }

 private:
  template <class List>
  void find(const List& values, const List& global, std::vector<char>& taken) {
    const auto valueAt = [this](const List& list, std::size_t i) {
      return List(list.begin() + long(i * width_), list.begin() + long((i + 1) * width_));
    };
    std::map<List, std::vector<std::size_t>> places;
    for (std::size_t g = 0; g < count(global_); ++g) places[valueAt(global, g)].push_back(g);
    for (std::size_t v = 0; v < count(values_); ++v) {
      const auto found = places.find(valueAt(values, v));
      if (found == places.end()) continue;
      for (const std::size_t g : found->second) {
        indices_.push_back(int(g));
        taken[g] = 1;
        if (!all_) break;
      }
    }
  }
  ValueList values_, global_;
  bool all_ = false;
  std::vector<int> indices_, others_;
};

class IndexValueMapper final : public TypedEngine {
 public:
  void declare(DataTable& table) override {
    TypedEngine::declare(table);
    addList(table, "inputValues", in_).help("values to start from");
    table.add("indices", indices_).help("where value goes");
    addList(table, "value", value_).help("the value").required();
    addList(table, "defaultValue", otherwise_).help("where the list grows; 1 by default");
    addList(table, "outputValues", out_).help("the list").output();
  }
  void init() override {
    checkWhole(in_, "inputValues");
    if (count(value_) != 1) throw ComponentError(fmt::format("value holds {} values", count(value_)), "one");
    out_ = in_;
    withNumbers(
        [this](const auto& value, auto& otherwise, auto& out) {
          if (otherwise.empty()) otherwise.assign(width_, 1);
          for (const int index : indices_) {
            constexpr int most = 10'000'000;
            if (index < 0 || index > most)
              throw ComponentError(fmt::format("indices names {}", index), fmt::format("numbers from 0 to {}", most));
            while (out.size() <= std::size_t(index) * width_) copyValue(otherwise, 0, out);
            std::copy(value.begin(), value.begin() + long(width_), out.begin() + long(std::size_t(index) * width_));
          }
        },
        value_, otherwise_, out_);
  }

 private:
  ValueList in_, value_, otherwise_, out_;
  std::vector<int> indices_;
};

class Indices2ValuesMapper final : public TypedEngine {
 public:
  void declare(DataTable& table) override {
    TypedEngine::declare(table);
    addList(table, "inputValues", in_).help("a label of each item");
    addList(table, "indices", labels_).help("labels that have a value");
    addList(table, "values", values_).help("the value of each of them");
    addList(table, "defaultValue", otherwise_).help("of other labels; 1 by default");
    addList(table, "outputValues", out_).help("a value of each item").output();
  }
  void init() override {
    if (count(labels_) != count(values_))
      throw ComponentError(fmt::format("there are {} indices and {} values", count(labels_), count(values_)), "as many");
    out_.clear();
    withNumbers(
        [](const auto& in, const auto& labels, const auto& values, const auto& otherwise, auto& out) {
          for (const auto label : in) {
            const auto at = std::find(labels.begin(), labels.end(), label);
            out.push_back(at != labels.end() ? values[std::size_t(at - labels.begin())] : otherwise.empty() ? 1 : otherwise[0]);
          }
        },
        in_, labels_, values_, otherwise_, out_);
  }

 private:
  ValueList in_, labels_, values_, otherwise_, out_;
};

class MergeVectors final : public TypedEngine {
 public:
  void declare(DataTable& table) override {
    TypedEngine::declare(table);
    table.add("nbInputs", number_).help("how many lists").min(1).max(int(most_inputs));
    for (std::size_t i = 0; i < most_inputs; ++i)
      addList(table, fmt::format("input{}", i + 1), in_[i]).help(fmt::format("list {}", i + 1));
    addList(table, "output", out_).help("all of them").output();
  }
  void init() override {
    out_.clear();
    for (std::size_t i = 0; i < std::size_t(number_); ++i)
      withNumbers([](const auto& in, auto& out) { out.insert(out.end(), in.begin(), in.end()); }, in_[i], out_);
  }

 private:
  int number_ = 2;
  std::array<ValueList, most_inputs> in_;
  ValueList out_;
};

class MergeSets final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("in1", a_).help("the first set");
    table.add("in2", b_).help("the second set");
    table.addChoice("op", op_, {"union", "intersection", "difference", "symmetric_difference"}).help("what of them is taken");
    table.add("out", out_).help("the result, ascending").output();
  }
  void init() override {
    for (std::vector<int>* set : {&a_, &b_}) {
      std::sort(set->begin(), set->end());
      set->erase(std::unique(set->begin(), set->end()), set->end());
    }
    out_.clear();
    const auto into = std::back_inserter(out_);
    if (op_ == Op::all) std::set_union(a_.begin(), a_.end(), b_.begin(), b_.end(), into);
    if (op_ == Op::common) std::set_intersection(a_.begin(), a_.end(), b_.begin(), b_.end(), into);
    if (op_ == Op::without) std::set_difference(a_.begin(), a_.end(), b_.begin(), b_.end(), into);
    if (op_ == Op::either) std::set_symmetric_difference(a_.begin(), a_.end(), b_.begin(), b_.end(), into);
  }

 private:
  enum class Op : int { all, common, without, either } op_ = Op::all;
  std::vector<int> a_, b_, out_;
};

class MergePoints final : public TypedEngine {
 public:
  MergePoints() : TypedEngine(3) {}
  void declare(DataTable& table) override {
    TypedEngine::declare(table);
    addList(table, "position1", a_).help("the first points").unit("m");
    addList(table, "position2", b_).help("the second points").unit("m");
    table.add("mappingX2", places_).help("which of the first points the second ones replace");
    addList(table, "points", out_).help("both").unit("m").output();
    table.add("indices1", first_).help("where the first are").output();
    table.add("indices2", second_).help("where the second are").output();
    table.addVisualOnly("noUpdate");
  }
  void init() override {
    checkWhole(a_, "position1"), checkWhole(b_, "position2");
    out_ = a_;
    if (!places_.empty()) return replace();
    out_.reals.insert(out_.reals.end(), b_.reals.begin(), b_.reals.end());
    first_.resize(count(a_)), second_.resize(count(b_));
    for (std::size_t i = 0; i < first_.size(); ++i) first_[i] = int(i);
    for (std::size_t i = 0; i < second_.size(); ++i) second_[i] = int(first_.size() + i);
  }

 private:
  void replace() {
    if (places_.size() > count(b_))
      throw ComponentError(fmt::format("mappingX2 has {} places for {} points", places_.size(), count(b_)), "a point for each");
    std::vector<char> taken(count(a_));
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (places_[i] < 0 || std::size_t(places_[i]) >= taken.size())
        throw ComponentError(fmt::format("mappingX2 names {}, and position1 has {} points", places_[i], taken.size()));
      const auto place = std::size_t(places_[i]);
      taken[place] = 1;
      for (std::size_t c = 0; c < width_; ++c) out_.reals[place * width_ + c] = b_.reals[i * width_ + c];
    }
    first_.clear(), second_.clear();
    for (std::size_t i = 0; i < taken.size(); ++i) (taken[i] ? second_ : first_).push_back(int(i));
  }
  ValueList a_, b_, out_;
  std::vector<int> places_, first_, second_;
};

class DifferenceEngine final : public TypedEngine {
 public:
  void declare(DataTable& table) override {
    TypedEngine::declare(table);
    addList(table, "input", in_).help("values");
    addList(table, "substractor", less_).help("what is taken off");
    addList(table, "output", out_).help("the difference").output();
  }
  void init() override {
    checkWhole(in_, "input"), checkWhole(less_, "substractor");
    if (count(in_) != count(less_))
      throw ComponentError(fmt::format("there are {} values of input and {} of substractor", count(in_), count(less_)), "as many");
    out_ = in_;
    withNumbers(
        [](const auto& less, auto& out) {
          for (std::size_t i = 0; i < out.size(); ++i) out[i] -= less[i];
        },
        less_, out_);
  }

 private:
  ValueList in_, less_, out_;
};

class MathOp final : public TypedEngine {
 public:
  void declare(DataTable& table) override {
    TypedEngine::declare(table);
    table.add("nbInputs", number_).help("how many lists").min(1).max(int(most_inputs));
    for (std::size_t i = 0; i < most_inputs; ++i)
      addList(table, fmt::format("input{}", i + 1), in_[i]).help(fmt::format("list {}", i + 1));
    table.addChoice("op", op_, {"+", "-", "*", "/", "<", ">"}).help("what joins them, number by number; < the least, > the largest");
    addList(table, "output", out_).help("the result").output();
  }
  void init() override {
    out_ = in_[0];
    if (number_ == 1) withNumbers([this](auto& out) { invert(out); }, out_);
    for (std::size_t i = 1; i < std::size_t(number_); ++i)
      withNumbers([&](const auto& in, auto& out) { join(in, out, i); }, in_[i], out_);
  }

 private:
  template <class List>
  void invert(List& list) const {
    for (auto& number : list) {
      if (op_ == Op::divide && number == 0) throw ComponentError("input1 holds a zero to divide by");
      if (op_ == Op::subtract) number = -number;
      if (op_ == Op::divide) number = 1 / number;
    }
  }
  template <class List>
  void join(const List& in, List& out, std::size_t number) const {
    if (in.size() != width_ && in.size() != out.size())
      throw ComponentError(fmt::format("input{} holds {} numbers, and those before {}", number + 1, in.size(), out.size()),
                           "as many, or a single value");
    for (std::size_t k = 0; k < out.size(); ++k) {
      const auto other = in[in.size() == width_ ? k % width_ : k];
      if (op_ == Op::divide && other == 0) throw ComponentError(fmt::format("input{} holds a zero to divide by", number + 1));
      if (op_ == Op::add) out[k] += other;
      if (op_ == Op::subtract) out[k] -= other;
      if (op_ == Op::multiply) out[k] *= other;
      if (op_ == Op::divide) out[k] /= other;
      if (op_ == Op::least) out[k] = std::min(out[k], other);
      if (op_ == Op::largest) out[k] = std::max(out[k], other);
    }
  }
  int number_ = 2;
  enum class Op : int { add, subtract, multiply, divide, least, largest } op_ = Op::add;
  std::array<ValueList, most_inputs> in_;
  ValueList out_;
};

class ComplementaryROI final : public Engine {
 public:
  std::string roleText() const override { return "selection"; }
  void declare(DataTable& table) override {
    table.add("position", position_).help("all nodes").unit("m");
    table.add("nbSet", number_).help("how many sets").min(0).max(int(most_inputs));
    for (std::size_t i = 0; i < most_inputs; ++i)
      table.add(fmt::format("setIndices{}", i + 1), sets_[i]).help(fmt::format("set {}", i + 1));
    table.add("indices", indices_).help("nodes in none of the sets").output();
    table.add("pointsInROI", points_).help("their positions").unit("m").output();
  }
  void init() override {
    std::vector<char> taken(position_.size());
    for (std::size_t i = 0; i < std::size_t(number_); ++i)
      for (const int node : sets_[i])
        if (node >= 0 && std::size_t(node) < taken.size()) taken[std::size_t(node)] = 1;
    indices_.clear(), points_.clear();
    for (std::size_t node = 0; node < taken.size(); ++node)
      if (!taken[node]) indices_.push_back(int(node)), points_.push_back(position_[node]);
    if (indices_.empty()) warn("the sets hold all nodes: nothing is left");
  }

 private:
  std::vector<Vec3> position_, points_;
  int number_ = 1;
  std::array<std::vector<int>, most_inputs> sets_;
  std::vector<int> indices_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(value_engines) {
  factory.add<stroma::ValuesFromIndices>("ValuesFromIndices", "the values at listed places");
  factory.add<stroma::IndicesFromValues>("IndicesFromValues", "where values stand in a list");
  factory.add<stroma::IndexValueMapper>("IndexValueMapper", "a list with a value at listed places");
  factory.add<stroma::Indices2ValuesMapper>("Indices2ValuesMapper", "a value for each label");
  factory.add<stroma::MergeVectors>("MergeVectors", "several lists as one");
  factory.add<stroma::MergeSets>("MergeSets", "the union or another join of two sets of nodes");
  factory.add<stroma::MergePoints>("MergePoints", "two lists of points as one");
  factory.add<stroma::DifferenceEngine>("DifferenceEngine", "the difference of two lists");
  factory.add<stroma::MathOp>("MathOp", "sums, differences, products and quotients of lists");
  factory.add<stroma::ComplementaryROI>("ComplementaryROI", "selects the nodes that other selections leave");
}
