// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/modules.h"

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <iterator>
#include <map>
#include <mutex>
#include <sstream>
#include <stdexcept>

#include "framework/scene/abi.h"
#include "framework/scene/change_table.h"
#include "framework/scene/services.h"
#include "framework/scene/spans.h"
#include "framework/scene/text.h"

namespace stroma {

namespace fs = std::filesystem;

namespace {

/// Instruction sets from the best down; "" is a module built once for all machines.
constexpr std::array<const char*, 3> levels = {"x86-64-v4", "x86-64-v3", "x86-64-v2"};

std::size_t machineLevel() {
#if defined(__clang__) && __clang_major__ < 18  // does not know the levels
  if (__builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq"))
    return 0;
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2") ? 1 : 2;
#else
  if (__builtin_cpu_supports("x86-64-v4")) return 0;
  return __builtin_cpu_supports("x86-64-v3") ? 1 : 2;
#endif
}

std::vector<std::string> defaultFolders() {
  std::vector<std::string> folders{moduleFolder()};
  const char* list = std::getenv("STROMA_MODULE_PATH");
  std::istringstream parts(list ? list : "");
  for (std::string part; std::getline(parts, part, ':');)
    if (!part.empty()) folders.push_back(part);
  return folders;
}

/// Files of this ending; none where the folder cannot be read, which `error` says.
std::vector<fs::path> indexesIn(const std::string& folder, std::error_code& error) {
  std::vector<fs::path> files;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
    if (at->path().extension() == ".index") files.push_back(at->path());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

namespace {

/// The best that modules may be opened for: the machine's, or a lower one that STROMA_LEVEL names.
std::string highestLevel() {
  const std::size_t machine = machineLevel();
  const char* wanted = std::getenv("STROMA_LEVEL");
  if (!wanted || !*wanted) return levels[machine];
  const auto found = std::find(levels.begin(), levels.end(), std::string_view(wanted));
  if (found == levels.end())
    throw std::runtime_error("STROMA_LEVEL is " + inQuotes(wanted) + ": expected x86-64-v4, x86-64-v3 or x86-64-v2");
  if (std::size_t(found - levels.begin()) < machine)
    throw std::runtime_error(std::string("STROMA_LEVEL asks for ") + *found + " but this machine runs at most " +
                             levels[machine]);
  return *found;
}

/// OpenBLAS knows processors by their numbers, takes one that is newer than itself for the oldest there is, and then multiplies
/// matrices at a quarter of the speed. It reads this when the first module that needs it is opened; what a person set stays.
void nameBlasKernels() {
  constexpr const char* kernels = "OPENBLAS_CORETYPE";
  if (std::getenv(kernels)) return;
  const std::string level = instructionLevel();
  if (level != levels.back()) setenv(kernels, level == levels.front() ? "SkylakeX" : "Haswell", 0);
}

}  // namespace

std::string instructionLevel() {
  const std::string highest = highestLevel();
  for (auto level = std::find(levels.begin(), levels.end(), highest); level != levels.end(); ++level)
    if (fs::exists(fs::path(moduleFolder()) / *level)) return *level;
  return highest;
}

struct Modules::Impl {
  struct Source {
    std::string folder;  ///< that holds the index
    bool opened = false;
  };
  std::map<std::string, Source, std::less<>> modules;  ///< by name
  std::deque<std::string> texts;                       ///< of the indexes, which their entries are parts of
  std::vector<std::string> folders;                    ///< of the indexes
  std::vector<std::string> opened;
  std::vector<std::string> manual_files;
  std::map<std::string, std::string> pages;
  bool pages_read = false, told_of_folders = false;

  void readIndex(const fs::path& file, std::vector<IndexEntry>& index);
  void readManual(const std::string& file);
  std::string libraryOf(const std::string& module) const;
  void refuseUnbuilt(const std::string& type) const;
  void warnOfEmptyFolders();
};

/// Each start of a program reads them all: nothing is copied.
void Modules::Impl::readIndex(const fs::path& file, std::vector<IndexEntry>& index) {
  std::ifstream in(file);
  std::string_view left = texts.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  const auto cut = [](std::string_view& text, char end) {
    const std::string_view part = text.substr(0, text.find(end));
    text.remove_prefix(std::min(part.size() + 1, text.size()));
    return part;
  };
  while (!left.empty()) {
    const std::string_view line = cut(left, '\n');
    std::string_view fields = line;
    IndexEntry entry;
    entry.type = cut(fields, '\t'), entry.module = cut(fields, '\t'), entry.help = fields;
    if (entry.type.empty() || entry.module.empty())
      throw std::runtime_error(file.string() + " is not an index of modules: the line " + inQuotes(line) +
                               " lacks a type or a module");
    if (!modules.contains(entry.module)) modules.emplace(entry.module, Source{file.parent_path().string()});
    index.push_back(entry);
  }
  manual_files.push_back(fs::path(file).replace_extension(".manual").string());
}

/// Pages start with a line "=== Type<tab>module".
void Modules::Impl::readManual(const std::string& file) {
  std::ifstream in(file);
  std::string* page = nullptr;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("=== ")) {
      page = &pages[line.substr(4, line.find('\t') - 4)];
    } else if (page) {
      *page += line + "\n";
    }
  }
}

/// The best build of a module that this machine runs.
std::string Modules::Impl::libraryOf(const std::string& module) const {
  const fs::path folder = modules.at(module).folder;
  const std::string best = highestLevel();
  const std::string file = module + ".so";
  for (auto level = std::find(levels.begin(), levels.end(), best); level != levels.end(); ++level)
    if (fs::exists(folder / *level / file)) return (folder / *level / file).string();
  if (fs::exists(folder / file)) return (folder / file).string();
  if (std::none_of(levels.begin(), levels.end(), [&](const char* level) { return fs::exists(folder / level / file); }))
    throw std::runtime_error("the module " + module + " is not here: " +
                             howToGet(module, "it was not installed with the others in " + folder.string()));
  throw std::runtime_error("module " + module + " has no build for this machine (" + best + ") in " + folder.string());
}

/// A build folder lists the sources of its modules, a line "module<tab>source<tab>..." each. Throws for a type that one of
/// them registers in a module that has no index.
void Modules::Impl::refuseUnbuilt(const std::string& type) const {
  for (const std::string& folder : folders) {
    std::ifstream list(fs::path(folder) / "modules.sources");
    for (std::string line; std::getline(list, line);) {
      std::istringstream fields(line);
      std::string module;
      std::getline(fields, module, '\t');
      if (modules.count(module)) continue;
      for (std::string source; std::getline(fields, source, '\t');) {
        std::ifstream in(source);
        const std::string text(std::istreambuf_iterator<char>(in), {});
        if (text.find('"' + type + '"') == std::string::npos) continue;
        const std::string build = fs::path(folder).parent_path().parent_path().string();
        throw std::runtime_error("the module " + module + ", which has " + inQuotes(type) +
                                 ", is not built yet: 'cmake --build " + build + " --target stroma_" + module +
                                 "' builds it, 'tools/setup test' everything");
      }
    }
  }
}

/// Once, where a type is not found: it may have been looked for in the wrong place.
void Modules::Impl::warnOfEmptyFolders() {
  if (told_of_folders) return;
  told_of_folders = true;
  for (const std::string& folder : folders) {
    std::error_code error;
    if (folder == moduleFolder() || !indexesIn(folder, error).empty()) continue;
    std::cerr << "stroma: warning: STROMA_MODULE_PATH names " << inQuotes(folder)
              << (error ? ", which is not a readable folder\n"
                        : ", where no module lies: stroma_module() puts NAME.so and NAME.index there\n");
  }
}

Modules::Modules(Factory& factory) : Modules(factory, defaultFolders()) {}

Modules::Modules(Factory& factory, const std::vector<std::string>& index_folders)
    : factory_(factory), impl_(std::make_unique<Impl>()) {
  impl_->folders = index_folders;
  for (const std::string& folder : index_folders) {
    std::error_code none;
    for (const fs::path& file : indexesIn(folder, none)) impl_->readIndex(file, index_);
  }
  std::stable_sort(index_.begin(), index_.end(),
                   [](const IndexEntry& a, const IndexEntry& b) { return a.type < b.type; });
}

// Libraries stay open: components and factory entries hold their code until the process ends.
Modules::~Modules() = default;

bool Modules::provide(const std::string& type) {
  const std::string present(presentType(type));
  if (factory_.find(type) || factory_.find(present)) return true;
  for (const IndexEntry& entry : index_) {
    if (entry.type != type && entry.type != present) continue;
    const auto& [module, source] = *impl_->modules.find(entry.module);
    if (!source.opened) open(impl_->libraryOf(module));
    return factory_.find(type) || factory_.find(present);
  }
  impl_->refuseUnbuilt(present);
  impl_->warnOfEmptyFolders();
  return false;
}

void Modules::open(const std::string& path) {
  const Span span("open a module");
  nameBlasKernels();
  std::error_code none;  // without a slash the linker would look in its own folders only
  // lazily: symbols missing in the module itself are still reported (stroma_bound_at_once of cmake/StromaModule.cmake)
  void* library = dlopen((fs::exists(path, none) ? fs::absolute(path) : fs::path(path)).c_str(), RTLD_LAZY | RTLD_LOCAL);
  if (!library) throw std::runtime_error("the module " + path + " cannot be opened: " + dlerror());
  using Entry = const ModuleInfo* (*)();
  const auto entry = reinterpret_cast<Entry>(dlsym(library, "stroma_module"));
  if (!entry) throw std::runtime_error(path + " is not a module: it exports no function stroma_module");
  const ModuleInfo* info = entry();
  if (std::string_view(info->abi) != STROMA_ABI)
    throw std::runtime_error("the module " + path + " was built for " + info->abi +
                             " and this is " STROMA_ABI ": build it again against this version");
  if (std::find(impl_->opened.begin(), impl_->opened.end(), info->name) != impl_->opened.end()) return;

  // What a module registers with itself (laws, kinds of elements) it has once in the process, however many factories it
  // serves: the first registration writes it, the others find it there.
  static std::mutex registering;
  const std::lock_guard lock(registering);
  // A trial registration first: a name that exists must not leave half a module in the factory.
  Factory trial;
  info->register_components(trial);
  for (const ComponentEntry* component : trial.entries())
    if (const ComponentEntry* other = factory_.find(component->type))
      throw std::runtime_error("the module " + path + " brings a component '" + component->type +
                               "', which the module '" + other->module + "' already has");
  factory_.setModule(info->name);
  info->register_components(factory_);
  factory_.setModule({});
  impl_->opened.emplace_back(info->name);
  const auto known = impl_->modules.find(info->name);
  if (known != impl_->modules.end()) known->second.opened = true;
}

void Modules::openAll() {
  for (const auto& [name, source] : impl_->modules)
    if (!source.opened) open(impl_->libraryOf(name));
}

std::vector<std::string> Modules::opened() const { return impl_->opened; }

std::vector<std::string> Modules::notOpened() const {
  std::vector<std::string> names;
  for (const auto& [name, source] : impl_->modules)
    if (!source.opened) names.push_back(name);
  return names;
}

std::string Modules::manual(const std::string& type) const {
  if (!impl_->pages_read) {
    impl_->pages_read = true;
    for (const std::string& file : impl_->manual_files) impl_->readManual(file);
  }
  const auto page = impl_->pages.find(std::string(presentType(type)));
  return page == impl_->pages.end() ? std::string() : page->second;
}

}  // namespace stroma
