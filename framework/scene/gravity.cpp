// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/gravity.h"

#include "framework/scene/data.h"
#include "framework/scene/text.h"

namespace stroma {

std::optional<Problem> readGravity(std::string_view text, Vec3& gravity, std::string& note) {
  const std::string unit = "m/s^2";
  std::optional<Problem> problem = Data("gravity", &gravity).unit(unit).parse(text, DataOrigin::written);
  double along_y = 0;
  if (!problem || Data("gravity", &along_y).unit(unit).parse(text, DataOrigin::written)) return problem;
  gravity = Vec3(0, along_y, 0);
  if (along_y != 0) note = "gravity is one number and acts along y: 0 " + printReal(along_y) + " 0 " + unit;
  return {};
}

}  // namespace stroma
