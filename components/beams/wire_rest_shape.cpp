// SPDX-License-Identifier: LGPL-2.1-or-later
// WireRestShape: the shape of a catheter or a guide wire at rest, and what it is made of.
//
// With wireMaterials the stretches are those of RodStraightSection and RodSpireSection, from the handle to the tip. Without it the rod
// is straight up to straightLength, and from there on a helix (rod_sections.cpp has the formulas) with the attributes that end in
// Extremity. A helix begins with a bend of atan(spireHeight/(pi spireDiameter)), as in the plug-in; a stretch behind one begins
// where it ends.
//
// keyPoints are the lengths where nodes are always put: the handle, the end of the straight part and the tip by default.
// densityOfBeams says how many beams lie between two of them where all of that is out; when it has not as many numbers as there
// are, floor(5 straightLength/length) and floor(20 (1 - straightLength/length)), as in the plug-in; a helix has as many more as it
// takes for beams that turn by less than half a turn. numEdgesCollis says how many
// edges of a contact model lie there, numEdges how many edges the mesh of the rod has, along x, which goes to the container that
// `topology` names.
//
// Source: names, attributes, defaults and formulas are those of the plug-in BeamAdapter for SOFA, of the years before and after 2023.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <WireRestShape name="shape" length="0.35" straightLength="0.3" spireDiameter="0.5" spireHeight="0" densityOfBeams="6 4"
//     radius="0.001" radiusExtremity="0.001" youngModulus="1e9" youngModulusExtremity="1e8" massDensity="1000"/>
//   <EulerImplicitSolver newtonIterations="30" newtonTolerance="1e-10"/>
//   <SparseLDLSolver/>
//   <MeshTopology edges="0 1  1 2"/>
//   <MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1   0.3 0 0  0 0 0 1   0.35 0 0  0 0 0 1"/>
//   <WireBeamInterpolation name="wire" WireRestShape="@shape"/>
//   <AdaptiveBeamForceFieldAndMass interpolation="@wire" massDensity="1000"/>
//   <FixedProjectiveConstraint indices="0"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "components/beams/rod_shape.h"
#include "framework/mesh/cell_attributes.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class WireRestShape final : public RodShape {
 public:
  void declare(DataTable& table) override {
    table.addLink("wireMaterials", materials_).help("sections from the handle to the tip; replaces the following attributes");
    table.addLink("topology", output_).help("container of edges that takes the mesh of the rod");
    table.add("length", length_).help("of the rod").unit("m").min(0, false);
    table.add("straightLength", straight_).help("of its straight part").unit("m").min(0);
    table.add("spireDiameter", diameter_).help("of the helix behind it").unit("m").min(0, false);
    table.add("spireHeight", height_).help("along the axis of the helix in each turn").unit("m").min(0);
    table.add("keyPoints", key_points_).help("lengths where nodes are always put, from 0 to the tip").unit("m").min(0);
    table.add("densityOfBeams", densities_).help("how many beams lie between two of them").min(0);
    table.add("numEdges", drawn_edges_).help("of the mesh of the rod").min(1);
    table.add("numEdgesCollis", contact_edges_).help("edges of a contact model between two key points; 20 by default").min(1);
    for (const bool tip : {false, true}) {
      const std::string end = tip ? "Extremity" : "", where = tip ? " of the helix" : " of the straight part";
      Stuff& stuff = stuff_[tip ? 1 : 0];
      table.add("radius" + end, stuff.radius).help("of the section" + where).unit("m").min(0, false);
      table.add("innerRadius" + end, stuff.inner).help("of the bore" + where).unit("m").min(0);
      table.add("youngModulus" + end, stuff.young).help("Young's modulus" + where).unit("Pa").min(0, false);
      table.add("massDensity" + end, stuff.density).help("of the material" + where).unit("kg/m^3").min(0, false);
    }
    table.add("poissonRatio", poisson_).help("Poisson's ratio").unit("-").min(-1, false).max(0.5);
    table.add("procedural", procedural_).alias("isAProceduralShape").help("SOFA's; only true is supported");
    table.add("brokenIn2", is_broken_).help("SOFA's; only false is supported");
    table.add("filename", file_).help("SOFA's; a shape from a file is not supported");
    table.add("position", mesh_.position).help("nodes of the mesh of the rod").unit("m").output();
    addCellList(table, cell_kinds::edge, mesh_.edges).help("its edges").output();
    for (const char* name : {"nonProceduralScale", "drawRestShape", "loader"}) table.addVisualOnly(name);
  }

  void init() override {
    if (!procedural_ || !file_.empty())
      throw ComponentError("a shape from a mesh or a file is not supported",
                           "straightLength, spireDiameter and spireHeight, or wireMaterials");
    if (is_broken_) throw ComponentError("a rod that is broken in two is not supported", "brokenIn2=\"false\"");
    if (materials_.target())
      takeMaterials();
    else
      takeAttributes();
    makeMesh();
  }

 private:
  struct Stuff {
    double radius = 1, inner = 0, young = 5000, density = 1;
  };

  /// No beam of a helix may turn by half a turn at rest.
  void divideHelices(std::vector<RodStretch>& stretches) const {
    for (std::size_t i = 0; i < stretches.size(); ++i) {
      RodStretch& stretch = stretches[i];
      const int needed = int(std::ceil(stretch.turnPerLength() * stretch.length / 2.5));
      if (stretch.diameter > 0 && needed > std::max(stretch.beams, 1)) {
        warn(fmt::format("stretch {} turns by {:.3g} rad at rest in {} beams: it has {}, so that each turns by less than half a turn", i,
                         stretch.turnPerLength() * stretch.length, stretch.beams, needed),
             "a larger number in densityOfBeams, or nbEdgesCollis of a RodSpireSection");
        stretch.beams = needed;
      }
    }
  }

  void takeMaterials() {
    for (const char* name : {"length", "straightLength", "spireDiameter", "spireHeight", "keyPoints", "densityOfBeams", "numEdges",
                             "numEdgesCollis", "radius", "innerRadius", "youngModulus", "massDensity", "radiusExtremity",
                             "innerRadiusExtremity", "youngModulusExtremity", "massDensityExtremity", "poissonRatio"})
      if (data().find(name)->isSet()) throw ComponentError(fmt::format("{} and wireMaterials are both given", name), "one of them");
    std::vector<RodStretch> stretches;
    key_points_.assign(1, 0);
    for (const HasRodStretch* each : materials_.all()) {
      stretches.push_back(each->stretch());
      key_points_.push_back(key_points_.back() + each->stretch().length);
    }
    divideHelices(stretches);
    setStretches(std::move(stretches));
  }

  bool hasStraightPart() const { return straight_ >= 0.001 * length_; }
  bool hasHelix() const { return straight_ <= 0.999 * length_; }

  void takeAttributes() {
    if (straight_ > length_) {
      if (data().find("straightLength")->isSet())
        throw ComponentError(fmt::format("straightLength is {:g} and length {:g}", straight_, length_),
                             "a straight part no longer than the rod");
      straight_ = length_;
    }
    for (const bool tip : {false, true}) {
      if (tip ? !hasHelix() : !hasStraightPart()) continue;
      const std::string end = tip ? "Extremity" : "";
      const Stuff& stuff = stuff_[tip ? 1 : 0];
      for (const auto& [name, unit, value] : {std::tuple("youngModulus" + end, "Pa", stuff.young), {"radius" + end, "m", stuff.radius}})
        if (!data().find(name)->isSet()) warn(fmt::format("{} is not given: the default {:g} {} is used", name, value, unit));
    }
    findKeyPoints();
    std::vector<RodStretch> stretches;
    for (std::size_t i = 0; i + 1 < key_points_.size(); ++i) {
      RodStretch stretch;
      stretch.length = key_points_[i + 1] - key_points_[i];
      const bool is_helix = hasHelix() && (!hasStraightPart() || key_points_[i] > straight_ - 1e-9 * length_);
      if (is_helix) stretch.diameter = diameter_, stretch.height = height_;
      const Stuff& stuff = stuff_[is_helix ? 1 : 0];
      stretch.section = roundSection(stuff.radius, stuff.inner, stuff.young, poisson_);
      if (data().find(is_helix ? "massDensityExtremity" : "massDensity")->isSet()) stretch.section.density = stuff.density;
      stretch.beams = densities_[i], stretch.contact_edges = contact_edges_[i];
      stretches.push_back(stretch);
    }
    divideHelices(stretches);
    setStretches(std::move(stretches));
  }

  void findKeyPoints() {
    if (key_points_.empty()) {
      key_points_ = {0};
      if (hasStraightPart() && hasHelix()) key_points_.push_back(straight_);
      key_points_.push_back(length_);
    }
    for (std::size_t i = 0; i < key_points_.size(); ++i)
      if (i == 0 ? key_points_[i] != 0 : !(key_points_[i] > key_points_[i - 1]))
        throw ComponentError(fmt::format("keyPoints has {:g} at {}", key_points_[i], i), "ascending lengths from 0 on");
    if (key_points_.size() < 2 || std::abs(key_points_.back() - length_) > 1e-9 * length_)
      throw ComponentError(fmt::format("keyPoints end at {:g}, and length is {:g}", key_points_.back(), length_),
                           "the tip as the last one");
    if (hasStraightPart() && hasHelix() &&
        std::none_of(key_points_.begin(), key_points_.end(), [this](double at) { return std::abs(at - straight_) <= 1e-9 * length_; }))
      throw ComponentError(fmt::format("the end of the straight part, {:g}, is not among keyPoints", straight_), "a key point there");
    const std::size_t count = key_points_.size() - 1;
    if (densities_.size() > count) densities_.resize(count);
    if (densities_.size() < count) {
      if (data().find("densityOfBeams")->isSet())
        warn(fmt::format("densityOfBeams has {} numbers for {} stretches between key points: it is left out, as in SOFA", densities_.size(),
                         count),
             "one for each");
      densities_.clear();
      if (hasStraightPart()) densities_.push_back(int(std::floor(5 * straight_ / length_)));
      if (hasHelix()) densities_.push_back(int(std::floor(20 * (1 - straight_ / length_))));
      densities_.resize(count, 0);
    }
    if (!data().find("numEdgesCollis")->isSet()) contact_edges_.assign(count, 20);
    if (contact_edges_.size() != count)
      throw ComponentError(fmt::format("numEdgesCollis has {} numbers for {} stretches between key points", contact_edges_.size(), count),
                           "one for each");
  }

  void makeMesh() {
    mesh_ = Mesh();
    const auto add = [this](double from, double to, int edges) {
      for (int i = mesh_.position.empty() ? 0 : 1; i <= edges; ++i)
        mesh_.position.emplace_back(from + (to - from) * i / edges, 0, 0);
    };
    if (!materials_.target()) add(0, length_, drawn_edges_);
    for (std::size_t i = 0; materials_.target() && i < stretches().size(); ++i)
      add(key_points_[i], key_points_[i + 1], stretches()[i].drawn_edges);
    for (Index i = 0; i + 1 < mesh_.nodes(); ++i) mesh_.edges.push_back({i, i + 1});
  }

  LinkList<HasRodStretch> materials_{"stretch of a rod"};
  double length_ = 1, straight_ = 1, diameter_ = 0.1, height_ = 0.01, poisson_ = 0.49;
  std::array<Stuff, 2> stuff_{Stuff{}, Stuff{1, 0, 3000, 1}};  ///< of the straight part and of the helix
  std::vector<int> densities_, contact_edges_;
  int drawn_edges_ = 10;
  bool procedural_ = true, is_broken_ = false;
  std::string file_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(wire_rest_shape) {
  factory.add<stroma::WireRestShape>("WireRestShape", "the shape and the stuff of a catheter or a guide wire");
}
