// SPDX-License-Identifier: LGPL-2.1-or-later
// Services are libraries for the command rather than for scenes, such as the mesh generator. A service is an abstract class
// in framework/; its implementation is a shared library beside the modules that is opened on demand. This keeps heavy
// libraries, and those under the GPL, out of everything else.
#pragma once
#include <memory>
#include <string>

namespace stroma {

/// Exported by a service as `extern "C" const stroma::ServiceInfo* stroma_service()`. `abi` is STROMA_ABI and is
/// compared first; `role` is the name of the abstract class.
struct ServiceInfo {
  const char* abi;
  const char* role;
  void* (*make)();  ///< a new object of the role; owned by the caller
};

/// The folder of the modules, stroma/ beside the framework library; empty when it cannot be found.
std::string moduleFolder();

/// How to get a missing part (a module, service, reader or program by its name): the command that builds it where
/// moduleFolder() is that of a build, the package that has it where it was installed from packages, else `otherwise`.
std::string howToGet(const std::string& part, const std::string& otherwise);

/// Opens NAME.so in moduleFolder() and makes its object. Throws ComponentError with howToGet(name, missing) when there is
/// no such library, and when it is another version's or plays another role.
void* makeService(const std::string& name, const std::string& role, const std::string& missing);

/// The same with the type of the role, which names itself in `Role::role`, its library in `Role::library` and what to
/// do when it is missing in `Role::missing`.
template <class Role>
std::unique_ptr<Role> service() {
  return std::unique_ptr<Role>(static_cast<Role*>(makeService(Role::library, Role::role, Role::missing)));
}

}  // namespace stroma
