// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/algebra/ordering_lock.h"

namespace stroma {

std::mutex& orderingLock() {
  static std::mutex instance;
  return instance;
}

}  // namespace stroma
