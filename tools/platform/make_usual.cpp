// SPDX-License-Identifier: LGPL-2.1-or-later
#include <mutex>
#include <stdexcept>

#include "framework/scene/modules.h"
#include "framework/scene/usual_component.h"

namespace stroma {

/// By a factory of its own, as that of the scene may be in another thread's use. Libraries stay open in any case.
std::unique_ptr<Component> makeUsual(Part part) {
  static std::mutex making;
  static Factory factory;
  static Modules modules(factory);
  const std::lock_guard lock(making);
  const std::string type = usualComponent(part);
  if (!modules.provide(type)) throw std::runtime_error("no module has " + type);
  return factory.make(type);
}

}  // namespace stroma
