// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/python_scene.h"

#include <errno.h>  // program_invocation_name
#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <utility>

#include "tools/command/recorded_run.h"
#include "tools/session/scene_program.h"

namespace stroma::command {
namespace {

/// A list of scenes for `stroma regress` that has one in Python.
bool listsProgram(const std::string& file) {
  std::ifstream lines(file);
  for (std::string word; lines >> word;)
    if (isSceneProgram(word)) return true;
  return false;
}

/// The folder of the packages `stroma` and `Sofa`, beside this program: of the build, or as it is installed. Empty: neither.
std::vector<std::string> packageFolders() {
  const fs::path prefix = fs::read_symlink("/proc/self/exe").parent_path().parent_path();
  for (const auto& [module, sofa] : {std::pair(prefix / "python", prefix / "python_sofa"),
                                     std::pair(prefix / STROMA_PYTHON_FOLDER, prefix / STROMA_SOFA_FOLDER)})
    if (fs::is_directory(module / "stroma") && fs::is_directory(sofa / "Sofa")) return {sofa.string(), module.string()};
  return {};
}

/// A folder with the recording of a scene in Python.
bool isRecordedProgram(const std::string& folder) {
  std::error_code no_folder;
  if (!fs::is_directory(folder, no_folder)) return false;
  try {
    return isSceneProgram(recordedRun(folder).scene);
  } catch (const std::exception&) {  // who opens it says what is wrong with it
    return false;
  }
}

}  // namespace

bool needsPython(const Arguments& arguments) {
  if (arguments.empty()) return false;
  if (arguments[0] == "sweep" || arguments[0] == "watch") return false;  // whose runs are commands of their own
  if (arguments[0] == "check" && std::find(arguments.begin(), arguments.end(), "--sofa") != arguments.end()) return false;  // as those
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    std::error_code no_file;
    if ((arguments[0] == "view" || arguments[0] == "picture") && isRecordedProgram(arguments[i])) return true;
    if (!fs::is_regular_file(arguments[i], no_file)) continue;
    if (isSceneProgram(arguments[i]) || (arguments[0] == "regress" && listsProgram(arguments[i]))) return true;
  }
  return false;
}

int goOnInPython(const Arguments& arguments) {
  const std::vector<std::string> folders = packageFolders();
  if (folders.empty()) {
    fmt::print(stderr, "stroma: a scene in Python needs the Python module (package python3-stroma), which is not installed\n");
    return exit_bad_input;
  }
  std::string path = folders[0] + ":" + folders[1];
  if (const char* before = getenv("PYTHONPATH"); before && *before) path += std::string(":") + before;
  setenv("PYTHONPATH", path.c_str(), 1);
  setenv("STROMA_COMMAND_NAME", program_invocation_name, 1);
  const char* chosen = getenv("STROMA_PYTHON");
  std::vector<std::string> words = {chosen && *chosen ? chosen : STROMA_PYTHON, "-m", "Sofa.command"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  execvp(pointers[0], pointers.data());
  fmt::print(stderr, "stroma: a scene in Python needs {}, which cannot be run: {} (STROMA_PYTHON names another one)\n", words[0],
             std::strerror(errno));
  return exit_bad_input;
}

}  // namespace stroma::command
