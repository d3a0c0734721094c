// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/services.h"

#include <dlfcn.h>

#include <filesystem>
#include <fstream>

#include "framework/scene/abi.h"
#include "framework/scene/diagnostics.h"
#include "framework/scene/modules.h"

namespace stroma {

namespace fs = std::filesystem;

std::string moduleFolder() {
  Dl_info info{};
  if (!dladdr(reinterpret_cast<const void*>(&moduleFolder), &info) || !info.dli_fname) return {};
  std::error_code none;
  const fs::path library = fs::canonical(info.dli_fname, none);
  return none ? std::string() : (library.parent_path() / "stroma").string();
}

namespace {

/// The second word of the line "name<tab>word" of a list in moduleFolder(), or empty.
std::string listed(const char* list, const std::string& name) {
  std::ifstream lines(fs::path(moduleFolder()) / list);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with(name + '\t')) return line.substr(name.size() + 1);
  return {};
}

}  // namespace

std::string howToGet(const std::string& part, const std::string& otherwise) {
  if (const std::string package = listed("parts.packages", part); !package.empty())
    return "install the package " + package;
  if (const std::string target = listed("parts.targets", part); !target.empty())
    return "'cmake --build " + fs::path(moduleFolder()).parent_path().parent_path().string() + " --target " + target +
           "' builds it";
  return otherwise;
}

// The library stays open: the object's code is in it.
void* makeService(const std::string& name, const std::string& role, const std::string& missing) {
  const fs::path path = fs::path(moduleFolder()) / (name + ".so");
  if (!fs::exists(path))
    throw ComponentError("there is no " + role + " here: " + howToGet(name, missing), path.string());
  void* library = dlopen(path.c_str(), RTLD_LAZY | RTLD_LOCAL);
  if (!library) throw ComponentError("the " + role + " cannot be opened: " + dlerror());
  using Entry = const ServiceInfo* (*)();
  const auto entry = reinterpret_cast<Entry>(dlsym(library, "stroma_service"));
  if (!entry) throw ComponentError(path.string() + " is not a service: it exports no function stroma_service");
  const ServiceInfo* info = entry();
  if (std::string_view(info->abi) != STROMA_ABI)
    throw ComponentError(path.string() + " was built for " + info->abi + " and this is " STROMA_ABI);
  if (role != info->role) throw ComponentError(path.string() + " is a " + info->role, "a " + role);
  return info->make();
}

}  // namespace stroma
