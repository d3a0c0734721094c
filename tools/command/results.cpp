// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/results.h"

#include <errno.h>  // program_invocation_name
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <filesystem>

#include "framework/scene/services.h"
#include "tools/picture/picture_maker.h"
#include "tools/platform/program_named.h"
#include "tools/session/file_uses.h"
#include "tools/view/viewer.h"

namespace stroma::command {
namespace {

namespace fs = std::filesystem;

/// Whether the library of a service was built; it is not opened.
template <class Role>
bool isBuilt() {
  return fs::exists(fs::path(moduleFolder()) / (std::string(Role::library) + ".so"));
}

/// As a shell takes it for one word.
std::string quoted(const std::string& word) {
  const auto is_plain = [](unsigned char c) { return std::isalnum(c) || std::strchr("_./+-=:@%,", c); };
  if (!word.empty() && std::all_of(word.begin(), word.end(), is_plain)) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

/// This program as it was called.
std::string program() { return quoted(program_invocation_name); }

std::vector<std::string> writtenFiles(const Simulation& simulation) {
  std::vector<std::string> files;
  const auto is_collection = [](const std::string& file) { return file.ends_with(".pvd"); };
  for (const Observer* observer : simulation.observers()) {
    std::vector<std::string> written = observer->files();
    std::error_code error;
    std::erase_if(written, [&](const std::string& file) { return !fs::exists(file, error); });
    if (std::any_of(written.begin(), written.end(), is_collection))
      std::erase_if(written, [&](const std::string& file) { return !is_collection(file); });
    files.insert(files.end(), written.begin(), written.end());
  }
  return files;
}

}  // namespace

Results resultsOf(const Simulation& simulation, const std::string& recording) {
  Results results{recording, writtenFiles(simulation), {}};
  if (!recording.empty()) {
    if (isBuilt<view::Viewer>()) results.commands.push_back(program() + " view " + quoted(recording));
    if (isBuilt<picture::PictureMaker>()) results.commands.push_back(program() + " picture " + quoted(recording));
  }
  if (!programNamed("paraview").empty())
    for (const std::string& file : results.files)
      if (file.ends_with(".pvd") || file.ends_with(".vtu") || file.ends_with(".vtk"))
        results.commands.push_back("paraview " + quoted(file));
  return results;
}

nlohmann::ordered_json Results::json() const {
  return {{"recording", recording}, {"files", files}, {"commands", commands}};
}

void Results::print() const {
  constexpr std::size_t most = 4;
  if (!recording.empty()) fmt::print("recorded in {}\n", recording);
  if (!files.empty())
    fmt::print("written: {}{}\n", fmt::join(files.begin(), files.begin() + long(std::min(most, files.size())), ", "),
               files.size() > most ? fmt::format(" and {} more", files.size() - most) : "");
  if (!commands.empty())
    fmt::print("to look at it: {}\n",
               fmt::join(commands.begin(), commands.begin() + long(std::min(most, commands.size())), "  or  "));
}

}  // namespace stroma::command
