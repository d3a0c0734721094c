// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/file_uses.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <filesystem>
#include <map>
#include <variant>

#include "framework/scene/component.h"
#include "framework/simulation/simulation.h"

namespace stroma {
namespace {

namespace fs = std::filesystem;

/// Who uses a file, by its path without links and by what it is on its disk.
class Users {
 public:
  /// Who has been added with the same file before, or null.
  const FileUse* find(const FileUse& use) const {
    const Identity identity(use.path);
    if (identity.is_special) return nullptr;
    if (const auto known = by_path_.find(identity.path); known != by_path_.end()) return known->second;
    if (!identity.number) return nullptr;
    const auto known = by_number_.find(*identity.number);
    return known == by_number_.end() ? nullptr : known->second;
  }
  /// `use` must stay where it is.
  void add(const FileUse& use) {
    const Identity identity(use.path);
    if (identity.is_special) return;
    by_path_.emplace(identity.path, &use);
    if (identity.number) by_number_.emplace(*identity.number, &use);
  }

 private:
  using Number = std::pair<dev_t, ino_t>;
  struct Identity {
    explicit Identity(const std::string& file) {
      std::error_code error;
      path = fs::absolute(file, error).lexically_normal().string();
      // links of folders; of a path that is relative and not there it would make nothing
      if (const fs::path resolved = fs::weakly_canonical(fs::absolute(file, error), error); !error)
        path = resolved.string();
      struct stat status {};
      if (::stat(file.c_str(), &status) != 0) return;
      is_special = !S_ISREG(status.st_mode);
      number = {status.st_dev, status.st_ino};
    }
    std::string path;
    std::optional<Number> number;  ///< of a file that is there
    bool is_special = false;       ///< a device or a pipe
  };
  std::map<std::string, const FileUse*> by_path_;
  std::map<Number, const FileUse*> by_number_;
};

}  // namespace

std::vector<FileUse> inputsOf(const Scene& scene) {
  std::vector<FileUse> inputs;
  for (const std::string& file : scene.description.files) inputs.push_back({file, "the scene"});
  std::vector<Component*> components;
  scene.root->collect(components);
  for (const Component* component : components)
    for (const Data& data : component->data().all())
      if (data.isInputFile())
        if (const FileName& file = **std::get_if<FileName*>(&data.pointer()); !file.found.empty())
          inputs.push_back({file.found, component->path()});
  return inputs;
}

std::vector<FileUse> outputsOf(const Simulation& simulation) {
  std::vector<FileUse> outputs;
  for (const Observer* observer : simulation.observers())
    for (const std::string& file : observer->files())
      outputs.push_back({file, observer->path(), observer->replacesFiles()});
  return outputs;
}

std::optional<std::string> overwriting(const std::vector<FileUse>& outputs, const std::vector<FileUse>& inputs) {
  Users readers, writers;
  for (const FileUse& input : inputs) readers.add(input);
  for (const FileUse& output : outputs) {
    if (const FileUse* reader = readers.find(output))
      return fmt::format("{} would overwrite {}, which {} reads", output.user, output.path, reader->user);
    if (const FileUse* writer = writers.find(output))
      return fmt::format("{} and {} would both write {}", writer->user, output.user, output.path);
    writers.add(output);
  }
  return std::nullopt;
}

void checkOverwriting(const Simulation& simulation, Diagnostics& diagnostics) {
  if (simulation.observers().empty()) return;
  const std::vector<FileUse> inputs = inputsOf(simulation.scene());
  std::vector<FileUse> outputs;
  for (const Observer* observer : simulation.observers()) {
    for (const std::string& file : observer->files())
      outputs.push_back({file, observer->path(), observer->replacesFiles()});
    const std::optional<std::string> sentence = overwriting(outputs, inputs);
    if (!sentence) continue;
    diagnostics.error(observer->where(), observer->path(), *sentence, "a file of its own");
    return;
  }
}

}  // namespace stroma
