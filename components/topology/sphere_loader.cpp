// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads spheres from a text file: a first line "sph 1.0", lines "nums COUNT" with their number, and lines "sphe NUMBER x y z r". # starts a
// comment. Other lines are skipped with a warning, as in SOFA. Centres are scaled, rotated and translated as by the mesh loaders. Radii are
// scaled by the first factor.
//
// Source: the format, names and attributes are SOFA's.
//
// Example:
// <Node name="root">
//   <SphereLoader name="loader" filename="meshes/two.sph"/>
//   <MechanicalObject position="@loader.position"/>
//   <SphereCollisionModel listRadius="@loader.listRadius"/>
// </Node>
#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "framework/mesh/mesh_loader.h"
#include "framework/scene/factory.h"
#include "framework/scene/text.h"

namespace stroma {
namespace {

class SphereLoader final : public MeshSource {
 public:
  void declare(DataTable& table) override {
    table.add("filename", filename_).help("file to read").input().required();
    table.add("scale3d", scale3d_).help("factors of the centres, first").unit("-");
    table.add("scale", scale_).help("one factor for all").unit("-").shorthand();
    table.add("rotation", rotation_).help("about x, then y, then z").unit("degree");
    table.add("translation", translation_).help("last").unit("m");
    table.add("position", position_).help("centres").unit("m").output();
    table.add("listRadius", radii_).help("radii").unit("m").output();
  }
  void init() override {
    if (data().find("scale")->isSet()) scale3d_.setConstant(scale_);
    std::ifstream stream(filename_.found);
    if (!stream) throw ComponentError(fmt::format("the file {} cannot be opened", filename_.given));
    position_.clear(), radii_.clear();
    const Mat3 turn = rotationFromDegrees(rotation_);
    std::string line, told, unknown;  // unknown: where the first line is that is none of these
    int left_out = 0;
    for (int number = 1; std::getline(stream, line); ++number) {
      std::istringstream words(line.substr(0, line.find('#')));
      std::string word;
      if (!(words >> word)) continue;
      if (word == "nums") words >> told;
      if (word == "sph" || word == "nums") continue;
      if (word != "sphe") {
        if (left_out++ == 0) unknown = fmt::format("{}:{}: {} is not read", filename_.given, number, inQuotes(line));
        continue;
      }
      int index = 0;
      Vec3 centre;
      double radius = 0;
      if (!(words >> index >> centre[0] >> centre[1] >> centre[2] >> radius) || !(radius >= 0) ||
          !centre.allFinite())
        throw ComponentError(fmt::format("{}:{}: {} is no sphere", filename_.given, number, inQuotes(line)),
                             "sphe NUMBER x y z r");
      position_.push_back(turn * centre.cwiseProduct(scale3d_) + translation_);
      radii_.push_back(radius * scale3d_[0]);
    }
    if (left_out > 0) warn(unknown + (left_out > 1 ? fmt::format(", nor are {} lines after it", left_out - 1) : ""), "sphe NUMBER x y z r");
    if (position_.empty()) throw ComponentError(fmt::format("{} holds no sphere", filename_.given), "lines sphe NUMBER x y z r");
    if (!told.empty() && told != std::to_string(position_.size()))
      warn(fmt::format("{} declares {} spheres, and contains {}: the file may be truncated", filename_.given, told, position_.size()));
  }

 private:
  FileName filename_;
  Vec3 scale3d_ = Vec3::Ones(), rotation_ = Vec3::Zero(), translation_ = Vec3::Zero();
  double scale_ = 1;
  std::vector<Vec3> position_;
  std::vector<double> radii_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(sphere_loader) {
  factory.add<stroma::SphereLoader>("SphereLoader", "reads the spheres of a .sph file");
}
