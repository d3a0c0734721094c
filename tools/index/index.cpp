// SPDX-License-Identifier: LGPL-2.1-or-later
// Writes the index and the manual of modules: which component lies in which module, with its one line of help, and the
// page that the leading comment of its source holds. Each module is opened once; afterwards nobody needs to.
#include <dlfcn.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "framework/scene/abi.h"
#include "framework/scene/modules.h"

namespace {

constexpr const char* usage =
    "stroma-index OUTDIR [--single] --module NAME FILE.so SOURCE.cpp... [--module ...]\n"
    "\n"
    "Opens each module, lists its components and writes OUTDIR/modules.index and OUTDIR/modules.manual.\n"
    "  --single   one module: writes OUTDIR/NAME.index and OUTDIR/NAME.manual instead, beside a module of\n"
    "             your own; add OUTDIR to STROMA_MODULE_PATH and its components are found by name\n"
    "\n"
    "Example: stroma-index . --single --module springs ./springs.so springs.cpp\n";

struct ModuleFiles {
  std::string name, library;
  std::vector<std::string> sources;
};

struct Page {
  std::string type, module, text;
};

std::string readFile(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file + " cannot be read");
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The first block of // lines after the licence line, markers removed.
std::string leadingComment(const std::string& source) {
  std::istringstream in(source);
  std::string page;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("// SPDX-License-Identifier")) continue;
    if (!line.starts_with("//")) {
      if (page.empty() && line.empty()) continue;
      break;
    }
    line.erase(0, line.starts_with("// ") ? 3 : 2);
    // A line of the text must not look like the start of a page.
    page += (line.starts_with("=== ") ? " " + line : line) + "\n";
  }
  return page;
}

/// The quoted words in the bodies of STROMA_COMPONENT(...) { ... }.
std::vector<std::string> registeredWords(const std::string& source) {
  std::vector<std::string> words;
  for (auto at = source.find("STROMA_COMPONENT("); at != std::string::npos;
       at = source.find("STROMA_COMPONENT(", at + 1)) {
    int depth = 0;
    for (auto i = source.find('{', at); i < source.size(); ++i) {
      if (source[i] == '"') {
        const auto end = source.find('"', i + 1);
        if (end == std::string::npos) break;
        words.push_back(source.substr(i + 1, end - i - 1));
        i = end;
      } else if (source[i] == '{') {
        ++depth;
      } else if (source[i] == '}' && --depth == 0) {
        break;
      }
    }
  }
  return words;
}

/// Names are resolved lazily: listing components calls nothing else of the module.
const stroma::ModuleInfo* openModule(const ModuleFiles& module) {
  void* library = dlopen(std::filesystem::absolute(module.library).c_str(), RTLD_LAZY | RTLD_LOCAL);
  if (!library) throw std::runtime_error("module " + module.name + " cannot be opened: " + dlerror());
  const auto entry = reinterpret_cast<const stroma::ModuleInfo* (*)()>(dlsym(library, "stroma_module"));
  if (!entry) throw std::runtime_error(module.library + " exports no function stroma_module");
  const stroma::ModuleInfo* info = entry();
  if (std::string_view(info->abi) != STROMA_ABI)
    throw std::runtime_error(module.library + " was built for " + info->abi + " and this is " STROMA_ABI);
  if (info->name != module.name)
    throw std::runtime_error(module.library + " calls itself " + info->name + ", not " + module.name);
  return info;
}

void addPages(const ModuleFiles& module, const stroma::Factory& factory, std::vector<Page>& pages) {
  std::map<std::string, std::string> text_of;
  for (const std::string& file : module.sources) {
    const std::string source = readFile(file), page = leadingComment(source);
    for (const std::string& word : registeredWords(source))
      if (factory.find(word)) text_of.emplace(word, page);
  }
  for (const stroma::ComponentEntry* entry : factory.entries()) {
    const auto page = text_of.find(entry->type);
    if (page == text_of.end() || page->second.empty())
      std::fprintf(stderr,
                   "stroma-index: warning: %s (module %s) has no manual page: its source has no leading comment\n",
                   entry->type.c_str(), module.name.c_str());
    else
      pages.push_back({entry->type, module.name, page->second});
  }
}

/// Written beside and moved, so that a process that reads the index never sees half of it.
void writeFile(const std::string& file, const std::string& text) {
  const std::string beside = file + ".new";
  std::ofstream out(beside);
  out << text;
  out.close();
  if (!out) throw std::runtime_error(file + " cannot be written");
  std::filesystem::rename(beside, file);
}

void writeIndex(const std::string& folder, bool single, const std::vector<ModuleFiles>& modules) {
  std::map<std::string, std::string> lines;  // by type
  std::vector<Page> pages;
  for (const ModuleFiles& module : modules) {
    stroma::Factory factory;
    openModule(module)->register_components(factory);
    for (const stroma::ComponentEntry* entry : factory.entries()) {
      const auto [known, is_new] =
          lines.emplace(entry->type, entry->type + "\t" + module.name + "\t" + entry->help + "\n");
      if (!is_new)
        throw std::runtime_error("component " + entry->type + " is in module " + module.name +
                                 " and in another: " + known->second);
    }
    addPages(module, factory, pages);
  }
  std::sort(pages.begin(), pages.end(), [](const Page& a, const Page& b) { return a.type < b.type; });
  std::string index, manual;
  for (const auto& [type, line] : lines) index += line;
  for (const Page& page : pages) manual += "=== " + page.type + "\t" + page.module + "\n" + page.text;
  std::filesystem::create_directories(folder);
  const std::string stem = folder + "/" + (single ? modules.front().name : "modules");
  writeFile(stem + ".manual", manual);
  writeFile(stem + ".index", index);
}

int run(const std::vector<std::string>& arguments) {
  if (arguments.empty() || arguments[0] == "--help" || arguments[0] == "-h") {
    std::fputs(usage, arguments.empty() ? stderr : stdout);
    return arguments.empty() ? 2 : 0;
  }
  bool single = false;
  std::vector<ModuleFiles> modules;
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    if (arguments[i] == "--single") {
      single = true;
    } else if (arguments[i] == "--module") {
      if (i + 2 >= arguments.size()) throw std::runtime_error("--module needs a name and a file");
      modules.push_back({arguments[i + 1], arguments[i + 2], {}});
      i += 2;
    } else if (modules.empty()) {
      throw std::runtime_error("unexpected argument " + arguments[i] + ": sources follow --module NAME FILE.so");
    } else {
      modules.back().sources.push_back(arguments[i]);
    }
  }
  if (single && modules.size() != 1) throw std::runtime_error("--single takes exactly one --module");
  writeIndex(arguments[0], single, modules);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "stroma-index: error: %s\n", error.what());
    return 2;
  }
}
