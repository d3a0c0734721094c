// SPDX-License-Identifier: LGPL-2.1-or-later
// RodStraightSection, RodSpireSection: a stretch of a rod that is straight at rest, or a helix. WireRestShape puts them one after
// another: wireMaterials="@handle @tip".
//
//   A = pi (r^2 - r_i^2),  Iy = Iz = pi (r^4 - r_i^4)/4,  J = 2 I
//   helix: theta = 2 pi s/l,  l^2 = spireHeight^2 + (pi spireDiameter)^2,
//          place = (spireDiameter/2 sin theta, spireHeight s/l, spireDiameter/2 (cos theta - 1))
//
// nbBeams is how many beams the stretch has where it is out; with 0, the usual value, nbEdgesCollis, which is how many edges of a
// contact model follow it. nbEdgesVisu is how many edges it has in the mesh of the rod.
//
// Source: names, attributes, defaults and formulas are those of the plug-in BeamAdapter for SOFA.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <RodStraightSection name="handle" length="0.3" radius="0.001" youngModulus="1e9" massDensity="1000" nbEdgesCollis="3"/>
//   <RodSpireSection name="tip" length="0.05" radius="0.001" youngModulus="1e8" spireDiameter="0.05" nbEdgesCollis="4"/>
//   <WireRestShape name="shape" wireMaterials="@handle @tip"/>
// </Node>
#include <fmt/format.h>

#include "components/beams/rod_shape.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class RodStretchComponent final : public HasRodStretch {
 public:
  bool is_helix = false;

  RodStretchComponent() { stretch_.beams = 0; }
  void declare(DataTable& table) override {
    table.add("length", stretch_.length).help("of the stretch").unit("m").min(0, false);
    table.add("radius", radius_).help("of its section").unit("m").min(0, false).physical();
    table.add("innerRadius", inner_).help("of its bore").unit("m").min(0);
    table.add("youngModulus", young_).help("Young's modulus").unit("Pa").min(0, false).physical();
    table.add("poissonRatio", poisson_).help("Poisson's ratio").unit("-").min(-1, false).max(0.5);
    table.add("massDensity", density_).help("of its material").unit("kg/m^3").min(0, false);
    table.add("nbEdgesVisu", stretch_.drawn_edges).help("edges in the mesh of the rod").min(1);
    table.add("nbEdgesCollis", stretch_.contact_edges).help("edges of a contact model, and beams without nbBeams").min(1);
    table.add("nbBeams", stretch_.beams).help("beams; 0: as many as nbEdgesCollis").min(0);
    table.add("spireDiameter", diameter_).help("of the helix; not for RodStraightSection").unit("m").min(0, false);
    table.add("spireHeight", height_).help("along the axis of the helix in each turn").unit("m").min(0);
  }

  void init() override {
    if (!is_helix && (data().find("spireDiameter")->isSet() || data().find("spireHeight")->isSet()))
      throw ComponentError("a straight stretch has no helix", "RodSpireSection");
    stretch_.section = roundSection(radius_, inner_, young_, poisson_);
    if (data().find("massDensity")->isSet()) stretch_.section.density = density_;
    if (stretch_.beams == 0) stretch_.beams = stretch_.contact_edges;
    if (is_helix) stretch_.diameter = diameter_, stretch_.height = height_;
  }
  const RodStretch& stretch() const override { return stretch_; }

 private:
  RodStretch stretch_;
  double radius_ = 1, inner_ = 0, young_ = 5000, poisson_ = 0.49, density_ = 1, diameter_ = 0.1, height_ = 0.01;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(rod_sections) {
  factory.add<stroma::RodStretchComponent>("RodStraightSection", "a straight stretch of a rod");
  factory.add<stroma::RodStretchComponent>("RodSpireSection", "a stretch of a rod that is a helix at rest",
                                           [](stroma::RodStretchComponent& made) { made.is_helix = true; });
}
