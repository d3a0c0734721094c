// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/common_attributes.h"

namespace stroma {

const std::vector<std::string>& commonAttributes() {
  static const std::vector<std::string> names = {"name",      "template", "src",  "printLog",
                                                 "listening", "tags",     "bbox", "componentState"};
  return names;
}

const std::vector<std::string>& nodeAttributes() {
  static const std::vector<std::string> names = {"name",
                                                 "gravity",
                                                 "dt",
                                                 "time",
                                                 "units",
                                                 "activated",
                                                 "animate",
                                                 "sleeping",
                                                 "tags",
                                                 "bbox",
                                                 "canChangeSleepingState",
                                                 "printLog",
                                                 "listening",
                                                 "componentState"};
  return names;
}

const std::vector<std::string>& templateWords() {
  static const std::vector<std::string> words = {
      "Vec3", "Vec3d",       "Vec3f",      "Rigid3", "Rigid3d",      "Rigid3f",        "Vec1", "Vec1d",
      "Vec2", "Vec2d",       "Vec6",       "Vec6d",  "StdVec3Types", "GraphScattered", "Edge", "Triangle",
      "Quad", "Tetrahedron", "Hexahedron", "Prism",  "Pyramid",      "double"};
  return words;
}

}  // namespace stroma
