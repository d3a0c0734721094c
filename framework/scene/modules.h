// SPDX-License-Identifier: LGPL-2.1-or-later
// Modules: shared libraries of components, opened only when a scene names something in them.
#pragma once
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "framework/scene/factory.h"

namespace stroma {

/// Exported by a module as `extern "C" const stroma::ModuleInfo* stroma_module()`. `abi` is STROMA_ABI (abi.h) and is
/// compared first: a module built against other headers is rejected with a message.
struct ModuleInfo {
  const char* abi;
  const char* name;
  void (*register_components)(Factory&);
};

/// Finds and opens modules. The index of a module (made at build time, one text line per component: name, module,
/// one-line help) answers which module holds a name without opening any. A module built for several instruction sets
/// lies in x86-64-v4/, -v3/ and -v2/ beside its index; the best one that this machine runs is opened.
class Modules {
 public:
  /// Reads the indexes beside the framework library, then those in the folders of STROMA_MODULE_PATH.
  explicit Modules(Factory& factory);
  /// Reads the indexes (*.index) of these folders only; none: no module is known.
  Modules(Factory& factory, const std::vector<std::string>& index_folders);
  ~Modules();

  struct IndexEntry {
    std::string_view type, module, help;  ///< parts of texts that the Modules keep
  };
  /// By type; of two modules with the same type the first one is opened.
  const std::vector<IndexEntry>& index() const { return index_; }

  /// Opens the module that holds `type` (after the change table) unless the factory knows it. False: no module has it.
  /// Throws std::runtime_error for a module that cannot be opened, also because it is not built yet.
  bool provide(const std::string& type);
  /// Opens a third-party module by path. Throws std::runtime_error with the reason if that fails.
  void open(const std::string& path);
  void openAll();

  std::vector<std::string> opened() const;     ///< names of modules opened so far, in order
  std::vector<std::string> notOpened() const;  ///< names in the index that were not
  /// The text of a component's manual page (leading comment of its source), or empty.
  std::string manual(const std::string& type) const;

 private:
  struct Impl;
  Factory& factory_;
  std::vector<IndexEntry> index_;
  std::unique_ptr<Impl> impl_;
};

/// The microarchitecture level of the modules used on this machine: "x86-64-v4", "-v3" or "-v2". STROMA_LEVEL lowers it.
std::string instructionLevel();

}  // namespace stroma
