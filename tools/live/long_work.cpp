// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/long_work.h"

#include <utility>

namespace stroma {
namespace {

MakeLongWorkListener& makeListener() {
  static MakeLongWorkListener make;
  return make;
}

}  // namespace

void listenToLongWork(MakeLongWorkListener make) { makeListener() = std::move(make); }

LongWork::LongWork(const std::string& what, double operations)
    : listener_(makeListener() ? makeListener()(what, operations) : nullptr) {}

}  // namespace stroma
