// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/gravity.h"

#include "framework/scene/data.h"
#include "framework/scene/text.h"

namespace stroma {

namespace {

std::string_view withoutPlus(std::string_view number) { return number.substr(number.starts_with('+') ? 1 : 0); }

}  // namespace

std::optional<Problem> readGravity(std::string_view text, Vec3& gravity, std::string& note) {
  const std::string unit = "m/s^2";
  std::optional<Problem> problem = Data("gravity", &gravity).unit(unit).parse(text, DataOrigin::written);
  double along_y = 0;
  if (!problem || Data("gravity", &along_y).unit(unit).parse(text, DataOrigin::written)) return problem;
  if (along_y > 0)
    return Problem{Severity::error, {}, {}, "gravity is one positive number, which would pull upwards, along y",
                   "a negative one, or three numbers",
                   "write -" + std::string(withoutPlus(trimmed(text)))};
  gravity = Vec3(0, along_y, 0);
  if (along_y != 0) note = "gravity is one number and acts along y: 0 " + printReal(along_y) + " 0 " + unit;
  return {};
}

}  // namespace stroma
