// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/scene/component.h"

namespace stroma::fuzz {

/// A component with an attribute of each type that attributes can have.
class EveryAttribute : public Component {
 public:
  void declare(DataTable& table) override {
    table.add("flag", flag_).help("a flag");
    table.add("count", count_).help("a number").min(-5).max(2'000'000'000);
    table.add("factor", factor_).help("a number").unit("-").min(0, false);
    table.add("text", text_).help("a text");
    table.add("direction", direction_).help("three numbers").unit("m");
    table.add("n", n_).help("three numbers");
    table.add("matrix", matrix_).help("16 numbers");
    table.add("flags", flags_).help("flags");
    table.add("indices", indices_).help("whole numbers");
    table.add("values", values_).help("numbers").unit("m").min(-1e300);
    table.add("position", position_).help("points").unit("m");
    table.add("words", words_).help("words");
    table.add("edges", edges_).help("pairs");
    table.add("triangles", triangles_).help("triples");
    table.add("tetrahedra", tetrahedra_).help("fours");
    table.add("sixes", sixes_).help("sixes");
    table.add("fives", fives_).help("fives");
    table.add("hexahedra", hexahedra_).help("eights");
    table.add("file", file_).help("a file");
    table.addChoice("method", method_, {"small", "large", "polar"}).help("a word");
    table.addLink("partner", partner_).help("another one");
    table.addVisualOnly("glow");
  }
  std::string roleText() const override { return "test component"; }

 private:
  enum class Method { small, large, polar };
  bool flag_ = false;
  int count_ = 0;
  double factor_ = 1;
  std::string text_;
  Vec3 direction_ = Vec3::Zero();
  std::array<int, 3> n_{};
  std::array<double, 16> matrix_{};
  std::vector<bool> flags_;
  std::vector<int> indices_;
  std::vector<double> values_;
  std::vector<Vec3> position_;
  std::vector<std::string> words_;
  std::vector<Edge> edges_;
  std::vector<Triangle> triangles_;
  std::vector<Quad> tetrahedra_;
  std::vector<std::array<Index, 6>> sixes_;
  std::vector<std::array<Index, 5>> fives_;
  std::vector<Hexahedron> hexahedra_;
  FileName file_;
  Method method_ = Method::small;
  Link<EveryAttribute> partner_{"a test component"};
};

}  // namespace stroma::fuzz
