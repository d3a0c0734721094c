// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>

#include <algorithm>

#include "framework/scene/diagnostics.h"
#include "framework/scene/reader_process.h"
#include "tools/mesh/label_image.h"

namespace stroma {
namespace {

const ReaderProgram program{"read_label_image", "the reader of images",
                            "`tools/setup build` in the sources installs VTK and builds it"};

}  // namespace

LabelImage readLabelImage(const std::string& file) {
  const ValueLists lists = readInOwnProcess(program, file);
  const Integers &size = lists.get<Integers>("size"), &values = lists.get<Integers>("values");
  const Reals &origin = lists.get<Reals>("origin"), &steps = lists.get<Reals>("steps");
  const Texts& region = lists.get<Texts>("region");
  const bool counted = size.size() == 3 && origin.size() == 3 && steps.size() == 9 && region.size() == 1;
  const auto fits = [&](std::int64_t side) { return side > 0 && side <= std::int64_t(region[0].size()); };
  const bool sized = counted && std::all_of(size.begin(), size.end(), fits) &&
                     double(size[0]) * double(size[1]) * double(size[2]) == double(region[0].size());
  const auto known = [&](char voxel) { return std::uint8_t(voxel) <= values.size(); };
  if (!sized || !std::all_of(region[0].begin(), region[0].end(), known))
    throw ComponentError(fmt::format("{}: the image's size and its voxels do not fit each other", file),
                         "a file that is not damaged");
  LabelImage image;
  std::copy(size.begin(), size.end(), image.size.begin());
  image.origin = Vec3::Map(origin.data());
  image.steps = Mat3::Map(steps.data());
  image.values.assign(values.begin(), values.end());
  image.region.assign(region[0].begin(), region[0].end());
  return image;
}

}  // namespace stroma
