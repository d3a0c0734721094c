// SPDX-License-Identifier: LGPL-2.1-or-later
// Writes the index and the manual of a module: its components, each with its one line of help, and the page that the
// leading comment of its source holds. The module is opened once; afterwards nobody needs to.
#include <dlfcn.h>

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
    "stroma-index OUTDIR NAME FILE.so SOURCE.cpp...\n"
    "\n"
    "Opens the module NAME in FILE.so, lists its components and writes OUTDIR/NAME.index and OUTDIR/NAME.manual. With\n"
    "OUTDIR in STROMA_MODULE_PATH its components are found by name.\n"
    "\n"
    "Example: stroma-index . springs ./springs.so springs.cpp\n";

struct ModuleFiles {
  std::string name, library;
  std::vector<std::string> sources;
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
    if (page.empty() && line.empty()) continue;
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

/// The pages of a module, by type: "=== Type<tab>module" and the text.
std::string manualOf(const ModuleFiles& module, const stroma::Factory& factory) {
  std::map<std::string, std::string> text_of;
  for (const std::string& file : module.sources) {
    const std::string source = readFile(file), page = leadingComment(source);
    for (const std::string& word : registeredWords(source))
      if (factory.find(word)) text_of.emplace(word, page);
  }
  std::string manual;
  for (const stroma::ComponentEntry* entry : factory.entries()) {
    const std::string& page = text_of[entry->type];
    if (page.empty())
      std::fprintf(stderr,
                   "stroma-index: warning: %s (module %s) has no manual page: its source has no leading comment\n",
                   entry->type.c_str(), module.name.c_str());
    else
      manual += "=== " + entry->type + "\t" + module.name + "\n" + page;
  }
  return manual;
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

void writeIndex(const std::string& folder, const ModuleFiles& module) {
  stroma::Factory factory;
  openModule(module)->register_components(factory);
  std::string index;
  for (const stroma::ComponentEntry* entry : factory.entries())
    index += entry->type + "\t" + module.name + "\t" + entry->help + "\n";
  std::filesystem::create_directories(folder);
  const std::string stem = folder + "/" + module.name;
  writeFile(stem + ".manual", manualOf(module, factory));
  writeFile(stem + ".index", index);
}

int run(const std::vector<std::string>& arguments) {
  const bool helps = !arguments.empty() && (arguments[0] == "--help" || arguments[0] == "-h");
  if (helps || arguments.size() < 3) {
    std::fputs(usage, helps ? stdout : stderr);
    return helps ? 0 : 2;
  }
  writeIndex(arguments[0], {arguments[1], arguments[2], {arguments.begin() + 3, arguments.end()}});
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
